#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace stillgrid::laboratory {

/// What a number may be.
struct NumberRange {
  double lowest = std::numeric_limits<double>::lowest();
  double highest = std::numeric_limits<double>::max();
};

/// A CSV file of ours as its cells: `# key: value` lines, one header line, rows as long as that.
class CsvFile {
 public:
  /// Throws std::runtime_error, `FILE:LINE: ...: expected ...`, for a file that cannot be read, has
  /// other columns than these, or a row of another length.
  CsvFile(std::filesystem::path file, std::string_view columns);

  [[nodiscard]] std::size_t rows() const noexcept { return rows_.size(); }
  [[nodiscard]] const std::string& text(std::size_t row, std::size_t column) const {
    return rows_[row][column];
  }
  /// Throws, as the constructor, for what is no finite number of that range.
  [[nodiscard]] double number(std::size_t row, std::size_t column,
                              const NumberRange& range = {}) const;

  /// A number of the head, `# key: value`. Throws where it is missing or none of that range.
  [[nodiscard]] double head_number(const std::string& key, const NumberRange& range = {}) const;
  [[nodiscard]] bool has_head(const std::string& key) const { return head_.contains(key); }

  /// Throws std::runtime_error for a row that is not as expected.
  [[noreturn]] void refuse(std::size_t row, const std::string& found,
                           const std::string& expected) const;

 private:
  [[noreturn]] void refuse_line(std::size_t line, const std::string& found,
                                const std::string& expected) const;

  struct HeadLine {
    std::string text;
    std::size_t line = 1;
  };
  std::filesystem::path file_;
  std::map<std::string, HeadLine> head_;
  std::vector<std::vector<std::string>> rows_;
  std::vector<std::size_t> lines_;  // of each row
};

}  // namespace stillgrid::laboratory
