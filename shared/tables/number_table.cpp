#include "shared/tables/number_table.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "shared/files/number_text.hpp"
#include "shared/files/text_file.hpp"

namespace stillgrid::tables {
namespace {

constexpr std::uintmax_t kMaxBytes = 1024 * files::kMiB;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // as some editors begin UTF-8

bool is_named(std::string_view field, const std::string& name) {
  return field == name || (name.ends_with("_m") && field == name + "m");
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t end = text.find(separator); end != std::string_view::npos;
       end = text.find(separator)) {
    parts.push_back(trimmed(text.substr(0, end)));
    text.remove_prefix(end + 1);
  }
  parts.push_back(trimmed(text));
  return parts;
}

NumberTable::NumberTable(const std::filesystem::path& file, std::string_view columns,
                         LastLine last_line)
    : file_(file.string()), content_(files::read_text(file, kMaxBytes)), rest_(content_) {
  if (rest_.starts_with(kByteOrderMark)) rest_.remove_prefix(kByteOrderMark.size());
  if (last_line == LastLine::kMayBeCut) rest_ = rest_.substr(0, rest_.rfind('\n') + 1);
  if (!next_line()) refuse_file("no whole header line: expected " + std::string(columns));
  header_ = fields_;
}

std::optional<Column> NumberTable::find(std::initializer_list<std::string> names) const {
  std::optional<Column> found;
  for (std::size_t i = 0; i < header_.size(); ++i) {
    const bool is_wanted = std::any_of(names.begin(), names.end(), [&](const std::string& name) {
      return is_named(header_[i], name);
    });
    if (!is_wanted) continue;
    const std::string name(header_[i]);
    if (found) refuse(name, "given twice, as " + found->name + ": expected once");
    found = Column{name, i, 1.0, name.ends_with("_mm") ? 1000.0 : 1.0};
  }
  return found;
}

Column NumberTable::require(std::initializer_list<std::string> names,
                            const std::string& expected) const {
  const auto found = find(names);
  if (!found) refuse(*names.begin(), "missing: expected " + expected);
  return *found;
}

std::vector<Column> NumberTable::find_group(std::initializer_list<std::string> names) const {
  std::vector<Column> group;
  std::string missing;
  for (const std::string& name : names) {
    if (const auto column = find({name}))
      group.push_back(*column);
    else if (missing.empty())
      missing = name;
  }
  if (!group.empty() && !missing.empty())
    refuse(missing, "missing: expected beside " + group.front().name);
  return group;
}

bool NumberTable::starts_with(std::string_view text) const {
  const std::string_view content = content_;
  return content.starts_with(text) || (content.starts_with(kByteOrderMark) &&
                                       content.substr(kByteOrderMark.size()).starts_with(text));
}

bool NumberTable::next_line() {
  while (!rest_.empty()) {
    const std::string_view line = rest_.substr(0, rest_.find('\n'));
    rest_.remove_prefix(std::min(line.size() + 1, rest_.size()));
    ++line_;
    const std::string_view text = trimmed(line);
    if (text.empty() || text.starts_with('#')) continue;
    fields_ = split(text, ',');
    return true;
  }
  return false;
}

bool NumberTable::next() {
  if (!next_line()) return false;
  if (fields_.size() != header_.size())
    refuse(std::string(header_.front()),
           "value '" + std::string(fields_.front().substr(0, 40)) + "': expected a row of " +
               std::to_string(header_.size()) + " fields, not " + std::to_string(fields_.size()));
  return true;
}

std::string_view NumberTable::text(const Column& column) const {
  return fields_[column.index];
}

double NumberTable::number(const Column& column) const {
  const auto value = files::finite_number(text(column));
  if (!value) refuse_value(column, "a finite number");
  return *value * column.factor / column.divisor;
}

double NumberTable::length_m(const Column& column) const {
  const double value_m = number(column);
  if (!(std::abs(value_m) <= kLongest_m)) refuse_value(column, "a length of at most 1e6 m");
  return value_m;
}

void NumberTable::refuse_value(const Column& column, const std::string& expected) const {
  refuse(column.name,
         "value '" + std::string(text(column).substr(0, 40)) + "': expected " + expected);
}

void NumberTable::refuse(const std::string& column, const std::string& fault) const {
  throw std::runtime_error(file_ + ":" + std::to_string(line_) + ": column " + column + ": " +
                           fault);
}

void NumberTable::refuse_file(const std::string& fault) const {
  throw std::runtime_error(file_ + ": " + fault);
}

}  // namespace stillgrid::tables
