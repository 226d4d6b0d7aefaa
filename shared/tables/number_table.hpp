#pragma once

#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace stillgrid::tables {

/// The farthest from zero that a length in a table may be, in metres.
inline constexpr double kLongest_m = 1e6;

/// A column that is read: its place, and how its unit becomes the SI unit.
struct Column {
  std::string name;
  std::size_t index = 0;
  double factor = 1.0;
  double divisor = 1.0;  // apart from factor: v / 1000 rounds once, v * 0.001 twice
};

/// Whether the last line counts without its newline, or is dropped: a program that was stopped may
/// have been writing it.
enum class LastLine { kWhole, kMayBeCut };

/// Text without the blanks around it.
[[nodiscard]] std::string_view trimmed(std::string_view text);
/// The parts between separators, each trimmed; one at least.
[[nodiscard]] std::vector<std::string_view> split(std::string_view text, char separator);

/// A CSV file of numbers (docs/formats.md, "Tables: CSV"), read row by row: a header line that
/// names the columns, then rows of as many fields. Skips blank lines, lines that begin with '#', a
/// byte order mark, and blanks around fields.
///
/// All functions throw std::runtime_error for a bad file: one line "FILE:LINE: column NAME: FAULT".
class NumberTable {
 public:
  /// Reads the file and its header. `columns` is the header that the message expects of an empty
  /// file.
  NumberTable(const std::filesystem::path& file, std::string_view columns, LastLine last_line);
  NumberTable(const NumberTable&) = delete;
  NumberTable& operator=(const NumberTable&) = delete;

  /// Returns the column with one of these names, or std::nullopt. Accepts `x_mm` for `x_m`, and
  /// converts it. Refuses a column that is there twice.
  [[nodiscard]] std::optional<Column> find(std::initializer_list<std::string> names) const;
  /// Returns the same. Refuses a header without it.
  [[nodiscard]] Column require(std::initializer_list<std::string> names,
                               const std::string& expected) const;
  /// Returns all of these columns, or an empty list if the header lacks all. Refuses a part of
  /// them.
  [[nodiscard]] std::vector<Column> find_group(std::initializer_list<std::string> names) const;

  /// Whether the file begins with that text, behind a byte order mark.
  [[nodiscard]] bool starts_with(std::string_view text) const;

  /// Moves on to the next row, false after the last. Refuses a row of another width.
  bool next();

  /// The line of the current row, counted from one.
  [[nodiscard]] std::size_t line() const noexcept { return line_; }
  /// The row's field, as it is written.
  [[nodiscard]] std::string_view text(const Column& column) const;
  /// The row's finite number, in the SI unit.
  [[nodiscard]] double number(const Column& column) const;
  /// The same of a length, of at most kLongest_m.
  [[nodiscard]] double length_m(const Column& column) const;

  /// Refuses the row's value of that column: "value 'V': expected EXPECTED".
  [[noreturn]] void refuse_value(const Column& column, const std::string& expected) const;
  [[noreturn]] void refuse(const std::string& column, const std::string& fault) const;
  /// Refuses the whole file: "FILE: FAULT".
  [[noreturn]] void refuse_file(const std::string& fault) const;

 private:
  bool next_line();

  std::string file_, content_;
  std::string_view rest_;  // behind the current row
  std::size_t line_ = 0;
  std::vector<std::string_view> header_, fields_;
};

}  // namespace stillgrid::tables
