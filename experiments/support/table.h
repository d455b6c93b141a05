#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace feder::experiments {

/// One value of a table: empty, a real number, a whole number or text.
class Cell {
 public:
  Cell() = default;
  template <std::floating_point T>
  Cell(T value) : value_(static_cast<double>(value)) {}
  template <std::integral T>
  Cell(T value) : value_(static_cast<std::int64_t>(value)) {}
  Cell(std::string value) : value_(std::move(value)) {}
  Cell(std::string_view value) : value_(std::string(value)) {}
  Cell(const char* value) : value_(std::string(value)) {}

  bool empty() const { return std::holds_alternative<std::monostate>(value_); }
  bool is_number() const { return !empty() && !std::holds_alternative<std::string>(value_); }
  /// NaN unless the cell holds a number.
  double number() const;
  /// Reals with 17 significant digits, which read back to the same bits.
  std::string text() const;
  /// Rounded to four significant digits for reading.
  std::string rounded() const;

 private:
  std::variant<std::monostate, double, std::int64_t, std::string> value_;
};

/// Long-format results: named columns, one row per run, missing values empty.
class Table {
 public:
  using Row = std::vector<std::pair<std::string_view, Cell>>;

  explicit Table(std::vector<std::string> columns = {});

  /// Appends a row: table.add({{"dt", 0.1}, {"status", "ok"}}).
  /// MisuseError for an undeclared or repeated column.
  void add(const Row& row);

  const std::vector<std::string>& columns() const { return columns_; }
  std::size_t rows() const { return rows_.size(); }
  bool has(std::string_view column) const;
  /// MisuseError for an undeclared column or a row out of range.
  const Cell& at(std::size_t row, std::string_view column) const;
  /// The distinct texts of a column in order of first appearance.
  std::vector<std::string> distinct(std::string_view column) const;

 private:
  std::size_t index(std::string_view column) const;

  std::vector<std::string> columns_;
  std::vector<std::vector<Cell>> rows_;
};

/// One field of CSV text, in quotes where RFC 4180 asks for them.
std::string csv_field(const std::string& text);
/// RFC 4180: header line, 17 significant digits, quotes where needed, lines end in a single line feed.
std::string to_csv(const Table& table);
/// Reads CSV text; numbers become number cells. `place` names the source in an InputError (row and column
/// included).
Table from_csv(std::string_view text, const std::string& place);
/// Atomic; throws IoError.
void write_csv(const Table& table, const std::filesystem::path& path);

/// Aligned columns, rounded. At most `max_rows` rows, then a line that says how many are left out.
std::string to_text(const Table& table, std::size_t max_rows = 60);
/// A <table> element, rounded and escaped, full values as tooltips; rows of failed runs are marked.
std::string to_html(const Table& table);

/// FNV-1a 64 of the CSV text without the columns whose name starts with "seconds": equal for equal results.
std::string results_hash(const Table& table);

}  // namespace feder::experiments
