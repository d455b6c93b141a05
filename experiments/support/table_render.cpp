#include <fmt/format.h>

#include <algorithm>

#include "experiments/support/html.h"
#include "experiments/support/table.h"

namespace feder::experiments {
namespace {

/// Number of characters, not bytes, of UTF-8 text.
std::size_t width(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

/// Control characters would move the cursor of a terminal.
std::string printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; }, ' ');
  return text;
}

bool holds_numbers(const Table& table, std::string_view column) {
  bool any = false;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const Cell& cell = table.at(row, column);
    if (!cell.empty() && !cell.is_number()) return false;
    any = any || cell.is_number();
  }
  return any;
}

/// One column as equally wide lines: name first, numbers to the right.
std::vector<std::string> aligned_column(const Table& table, const std::string& column, std::size_t rows) {
  std::vector<std::string> lines = {column};
  for (std::size_t row = 0; row < rows; ++row) lines.push_back(printable(table.at(row, column).rounded()));
  std::size_t widest = 0;
  for (const std::string& line : lines) widest = std::max(widest, width(line));
  const bool right = holds_numbers(table, column);
  for (std::string& line : lines) line.insert(right ? 0 : line.size(), widest - width(line), ' ');
  return lines;
}

bool is_failed(const Table& table, std::size_t row) {
  return table.has("status") && table.at(row, "status").text() != "ok";
}

}  // namespace

std::string to_text(const Table& table, std::size_t max_rows) {
  const std::size_t rows = std::min(max_rows, table.rows());
  std::vector<std::string> lines(rows + 1);
  for (const std::string& column : table.columns()) {
    const std::vector<std::string> column_lines = aligned_column(table, column, rows);
    for (std::size_t i = 0; i <= rows; ++i) lines[i] += (lines[i].empty() ? "" : "  ") + column_lines[i];
  }
  std::string text;
  for (std::string& line : lines) {
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  }
  if (rows < table.rows()) text += fmt::format("... and {} more rows in the CSV file\n", table.rows() - rows);
  return text;
}

std::string to_html(const Table& table) {
  std::string html = "<table>\n<thead><tr>";
  for (const std::string& column : table.columns()) {
    html += fmt::format("<th{}>{}</th>", holds_numbers(table, column) ? " class=\"number\"" : "",
                        html_escape(column));
  }
  html += "</tr></thead>\n<tbody>\n";
  for (std::size_t row = 0; row < table.rows(); ++row) {
    html += is_failed(table, row) ? "<tr class=\"failed\">" : "<tr>";
    for (const std::string& column : table.columns()) {
      const Cell& cell = table.at(row, column);
      html += fmt::format("<td{} title=\"{}\">{}</td>", cell.is_number() ? " class=\"number\"" : "",
                          html_escape(cell.text()), html_escape(cell.rounded()));
    }
    html += "</tr>\n";
  }
  return html + "</tbody>\n</table>\n";
}

}  // namespace feder::experiments
