#include "experiments/support/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/check.h"

namespace feder::experiments {

double Cell::number() const {
  if (const double* real = std::get_if<double>(&value_)) return *real;
  if (const std::int64_t* whole = std::get_if<std::int64_t>(&value_)) return static_cast<double>(*whole);
  return std::numeric_limits<double>::quiet_NaN();
}

std::string Cell::text() const {
  if (const double* real = std::get_if<double>(&value_)) return fmt::format("{:.17g}", *real);
  if (const std::int64_t* whole = std::get_if<std::int64_t>(&value_)) return std::to_string(*whole);
  if (const std::string* word = std::get_if<std::string>(&value_)) return *word;
  return {};
}

std::string Cell::rounded() const {
  if (const double* real = std::get_if<double>(&value_)) return fmt::format("{:.4g}", *real);
  return text();
}

Table::Table(std::vector<std::string> columns) : columns_(std::move(columns)) {
  std::vector<std::string> sorted = columns_;
  std::sort(sorted.begin(), sorted.end());
  FEDER_CHECK(std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end(),
              "a table names a column twice");
}

std::size_t Table::index(std::string_view column) const {
  const auto found = std::find(columns_.begin(), columns_.end(), column);
  if (found == columns_.end()) throw MisuseError("the table has no column '" + std::string(column) + "'");
  return static_cast<std::size_t>(found - columns_.begin());
}

void Table::add(const Row& row) {
  std::vector<Cell> cells(columns_.size());
  std::vector<bool> given(columns_.size(), false);
  for (const auto& [column, cell] : row) {
    const std::size_t i = index(column);
    if (given[i]) throw MisuseError("a row gives the column '" + std::string(column) + "' twice");
    given[i] = true;
    cells[i] = cell;
  }
  rows_.push_back(std::move(cells));
}

bool Table::has(std::string_view column) const {
  return std::find(columns_.begin(), columns_.end(), column) != columns_.end();
}

const Cell& Table::at(std::size_t row, std::string_view column) const {
  FEDER_CHECK(row < rows_.size(), "row index out of range");
  return rows_[row][index(column)];
}

std::vector<std::string> Table::distinct(std::string_view column) const {
  std::vector<std::string> words;
  for (std::size_t row = 0; row < rows(); ++row) {
    std::string word = at(row, column).text();
    if (std::find(words.begin(), words.end(), word) == words.end()) words.push_back(std::move(word));
  }
  return words;
}

}  // namespace feder::experiments
