#include "tests/laboratory/csv_file.hpp"

#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "shared/files/number_text.hpp"

namespace stillgrid::laboratory {
namespace {

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == ',')
      cells.emplace_back();
    else
      cells.back() += c;
  }
  return cells;
}

std::optional<double> number_in_text(const std::string& text, const NumberRange& range) {
  const auto value = files::finite_number(text);
  return value && *value >= range.lowest && *value <= range.highest ? value : std::nullopt;
}

/// " from 0 to 600"; nothing of what has no bounds.
std::string bounds_of(const NumberRange& range) {
  const NumberRange any;
  std::ostringstream text;
  if (range.lowest > any.lowest) text << " from " << range.lowest;
  if (range.highest < any.highest) text << " to " << range.highest;
  return text.str();
}

}  // namespace

CsvFile::CsvFile(std::filesystem::path file, std::string_view columns) : file_(std::move(file)) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file_, error))
    throw std::runtime_error(file_.string() + ": expected a file");
  std::ifstream stream(file_);
  if (!stream) throw std::runtime_error(file_.string() + ": expected a file that can be read");
  const std::size_t width = cells_of(std::string(columns)).size();
  bool has_header = false;
  std::size_t number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    if (line.starts_with("# ")) {
      const std::size_t colon = line.find(": ");
      if (colon != std::string::npos)
        head_[line.substr(2, colon - 2)] = {line.substr(colon + 2), number};
    } else if (!has_header) {
      if (line != columns) refuse_line(number, line, "the columns " + std::string(columns));
      has_header = true;
    } else {
      rows_.push_back(cells_of(line));
      lines_.push_back(number);
      if (rows_.back().size() != width)
        refuse_line(number, line, std::to_string(width) + " values");
    }
  }
  if (!has_header) refuse_line(1, "", "the columns " + std::string(columns));
}

double CsvFile::number(std::size_t row, std::size_t column, const NumberRange& range) const {
  const auto value = number_in_text(rows_[row][column], range);
  if (!value) refuse(row, rows_[row][column], "a number" + bounds_of(range));
  return *value;
}

double CsvFile::head_number(const std::string& key, const NumberRange& range) const {
  const auto found = head_.find(key);
  const HeadLine line = found == head_.end() ? HeadLine{.text = "missing"} : found->second;
  const auto value = number_in_text(line.text, range);
  if (!value)
    refuse_line(line.line, line.text,
                "a line '# " + key + ": NUMBER', a number" + bounds_of(range));
  return *value;
}

void CsvFile::refuse(std::size_t row, const std::string& found, const std::string& expected) const {
  refuse_line(lines_[row], found, expected);
}

void CsvFile::refuse_line(std::size_t line, const std::string& found,
                          const std::string& expected) const {
  constexpr std::size_t kMaxShown = 60;
  throw std::runtime_error(file_.string() + ":" + std::to_string(line) + ": value '" +
                           found.substr(0, kMaxShown) + "': expected " + expected);
}

}  // namespace stillgrid::laboratory
