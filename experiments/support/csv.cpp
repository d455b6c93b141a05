#include <algorithm>
#include <charconv>
#include <optional>

#include "engine/check.h"
#include "experiments/support/files.h"
#include "experiments/support/hash.h"
#include "experiments/support/table.h"

namespace feder::experiments {
namespace {

template <typename Keep>
std::string csv_of_columns(const Table& table, Keep&& keep) {
  std::vector<std::string> columns;
  for (const std::string& column : table.columns()) {
    if (keep(column)) columns.push_back(column);
  }
  std::string text;
  const auto append_line = [&](auto&& field) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (i > 0) text += ',';
      text += csv_field(field(columns[i]));
    }
    text += '\n';
  };
  append_line([](const std::string& column) { return column; });
  for (std::size_t row = 0; row < table.rows(); ++row) {
    append_line([&](const std::string& column) { return table.at(row, column).text(); });
  }
  return text;
}

template <typename Number>
std::optional<Number> whole_text(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

Cell to_cell(const std::string& text, bool quoted) {
  if (quoted) return text;
  if (text.empty()) return {};
  // Only what our writer would have written is a number: "007" or "1e3" must come back as they were.
  if (const auto whole = whole_text<std::int64_t>(text); whole && Cell(*whole).text() == text) return *whole;
  if (const auto real = whole_text<double>(text); real && Cell(*real).text() == text) return *real;
  return text;
}

/// Splits CSV text into records. Quoted fields may hold commas, quotes and line breaks.
class Reader {
 public:
  Reader(std::string_view text, const std::string& place) : text_(text), place_(place) {}

  bool more() const { return at_ < text_.size(); }

  std::vector<Cell> record() {
    ++record_;
    std::vector<Cell> cells;
    bool end = false;
    while (!end) {
      cells.push_back(field());
      end = at_ >= text_.size() || text_[at_] != ',';
      if (!end) ++at_;
    }
    if (text_.substr(at_, 2) == "\r\n") ++at_;
    if (at_ < text_.size() && text_[at_++] != '\n') fail("text after a closing quote");
    return cells;
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(place_ + ": record " + std::to_string(record_) + ": " + what);
  }

 private:
  Cell field() {
    if (at_ < text_.size() && text_[at_] == '"') return quoted_field();
    const std::size_t begin = at_;
    while (at_ < text_.size() && text_[at_] != ',' && text_[at_] != '\n') ++at_;
    std::string_view word = text_.substr(begin, at_ - begin);
    if (at_ < text_.size() && text_[at_] == '\n' && word.ends_with('\r')) word.remove_suffix(1);
    return to_cell(std::string(word), false);
  }

  Cell quoted_field() {
    std::string word;
    for (++at_; at_ < text_.size(); ++at_) {
      if (text_[at_] != '"') {
        word += text_[at_];
      } else if (text_.substr(at_, 2) == "\"\"") {
        word += text_[at_++];
      } else {
        ++at_;
        return to_cell(word, true);
      }
    }
    fail("a quoted field does not end");
  }

  std::string_view text_;
  const std::string& place_;
  std::size_t at_ = 0;
  std::size_t record_ = 0;
};

}  // namespace

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string field = "\"";
  for (const char c : text) field.append(c == '"' ? 2 : 1, c);
  return field + '"';
}

std::string to_csv(const Table& table) {
  return csv_of_columns(table, [](const std::string&) { return true; });
}

Table from_csv(std::string_view text, const std::string& place) {
  Reader reader(text, place);
  if (!reader.more()) throw InputError(place + ": empty, expected a header line");
  std::vector<std::string> columns;
  for (const Cell& cell : reader.record()) {
    const std::string name = cell.text();
    if (std::find(columns.begin(), columns.end(), name) != columns.end())
      reader.fail("the column '" + name + "' appears twice");
    columns.push_back(name);
  }
  Table table(columns);
  while (reader.more()) {
    const std::vector<Cell> cells = reader.record();
    if (cells.size() != columns.size()) {
      reader.fail(std::to_string(cells.size()) + " fields, expected " + std::to_string(columns.size()));
    }
    Table::Row row;
    for (std::size_t i = 0; i < cells.size(); ++i) row.emplace_back(columns[i], cells[i]);
    table.add(row);
  }
  return table;
}

void write_csv(const Table& table, const std::filesystem::path& path) {
  write_file(path, to_csv(table));
}

std::string results_hash(const Table& table) {
  const std::string text =
      csv_of_columns(table, [](const std::string& name) { return !name.starts_with("seconds"); });
  return text_hash(text);
}

}  // namespace feder::experiments
