#include "sim_server/toml/toml_reader.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "sim_server/toml/near_word.hpp"
#include "sim_server/toml/refusal.hpp"

namespace stillgrid::toml {
namespace {

constexpr double kLargest = 1e12;
constexpr double kSmallestPositive = 1e-9;
constexpr double kQuaternionTolerance = 1e-3;

std::string_view numbers_within(Bound bound) {
  switch (bound) {
    case Bound::kNotNegative:
      return "a number from 0 to 1e12";
    case Bound::kPositive:
      return "a number from 1e-9 to 1e12";
    default:
      return "a number from -1e12 to 1e12";
  }
}

double lowest_of(Bound bound) {
  if (bound == Bound::kAny) return -kLargest;
  return bound == Bound::kPositive ? kSmallestPositive : 0.0;
}

std::string integers_within(IntegerRange range) {
  if (range.lowest == range.highest) return std::to_string(range.lowest);
  return "an integer from " + std::to_string(range.lowest) + " to " + std::to_string(range.highest);
}

template <typename Texts>
std::string joined(const Texts& texts) {
  std::string list;
  for (const auto& text : texts) list.append(list.empty() ? "" : ", ").append(text);
  return list;
}

/// What ends the refusals of a table: its name, if it has one, else whose it is.
std::string owner_of(const ::toml::table& table, std::string_view prefix,
                     const std::string& otherwise) {
  const auto* const name = table.get_as<std::string>("name");
  if (name == nullptr || prefix.empty()) return otherwise;
  const std::string_view key = prefix.substr(0, prefix.size() - 1);
  return " (" + std::string(key.substr(key.rfind('.') + 1)) + " '" + shortened(name->get()) + "')";
}

}  // namespace

TableReader::TableReader(const ::toml::table& document, std::string file)
    : TableReader(document, std::move(file), "", document.source().begin, "") {}

TableReader::TableReader(const ::toml::table& table, std::string file, std::string prefix,
                         ::toml::source_position where, const std::string& owner)
    : table_(&table),
      file_(std::move(file)),
      prefix_(std::move(prefix)),
      where_(where),
      owner_(owner_of(table, prefix_, owner)) {}

bool TableReader::has(std::string_view key) {
  return find(key) != nullptr;
}

bool TableReader::has_text(std::string_view key) {
  const ::toml::node* node = find(key);
  return node != nullptr && node->is_string();
}

bool TableReader::has_number(std::string_view key) {
  const ::toml::node* node = find(key);
  return node != nullptr && node->is_number();
}

bool TableReader::has_table(std::string_view key) {
  const ::toml::node* node = find(key);
  return node != nullptr && node->is_table();
}
bool TableReader::has_tables(std::string_view key) {
  const ::toml::node* node = find(key);
  return node != nullptr && node->is_array() && !node->as_array()->empty();
}

double TableReader::number(std::string_view key, Bound bound) {
  return number_at(key, require(key, numbers_within(bound)), bound);
}

double TableReader::number_or(std::string_view key, Bound bound, double otherwise) {
  return has(key) ? number(key, bound) : otherwise;
}

std::vector<double> TableReader::numbers(std::string_view key, std::size_t count, Bound bound) {
  const std::string expected =
      std::to_string(count) + " numbers, each " + std::string(numbers_within(bound));
  const ::toml::array& array = require_array(key, expected);
  if (array.size() != count) refuse_at(key, array, expected);
  std::vector<double> values;
  for (const ::toml::node& node : array) values.push_back(number_at(key, node, bound));
  return values;
}

int TableReader::integer(std::string_view key, IntegerRange range) {
  return integer_at(key, require(key, integers_within(range)), range);
}

std::vector<int> TableReader::integers(std::string_view key, IntegerRange range) {
  const ::toml::array& array = require_array(key, "a list, each " + integers_within(range));
  std::vector<int> values;
  for (const ::toml::node& node : array) values.push_back(integer_at(key, node, range));
  return values;
}

Eigen::Vector3d TableReader::vector(std::string_view key, Bound bound) {
  return Eigen::Map<const Eigen::Vector3d>(numbers(key, 3, bound).data());
}

Eigen::Vector3d TableReader::vector_or(std::string_view key, const Eigen::Vector3d& otherwise) {
  return has(key) ? vector(key) : otherwise;
}

std::vector<Eigen::Vector3d> TableReader::vectors(std::string_view key) {
  constexpr std::string_view expected = "1 to 16 vectors, each of 3 numbers";
  const ::toml::array& array = require_array(key, expected);
  if (array.empty() || array.size() > 16) refuse_at(key, array, expected);
  std::vector<Eigen::Vector3d> vectors;
  for (const ::toml::node& node : array) {
    const ::toml::array* const numbers = node.as_array();
    if (numbers == nullptr || numbers->size() != 3) refuse_at(key, node, expected);
    Eigen::Vector3d& vector = vectors.emplace_back();
    for (std::size_t i = 0; i < 3; ++i)
      vector[static_cast<Eigen::Index>(i)] = number_at(key, (*numbers)[i], Bound::kAny);
  }
  return vectors;
}

Eigen::Vector3d TableReader::direction(std::string_view key) {
  const Eigen::Vector3d given = vector(key);
  const double length = given.norm();
  if (length < kSmallestPositive) refuse(key, "a vector that is not zero");
  return given / length;
}

Eigen::Quaterniond TableReader::orientation_or_identity(std::string_view key) {
  if (!has(key)) return Eigen::Quaterniond::Identity();
  const std::vector<double> xyzw = numbers(key, 4, Bound::kAny);
  const Eigen::Quaterniond given(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
  if (std::abs(given.norm() - 1.0) > kQuaternionTolerance) {
    refuse(key, "a quaternion x, y, z, w whose norm is within 1e-3 of 1");
  }
  return given.normalized();
}

std::string TableReader::name(std::string_view key) {
  constexpr std::string_view expected = "a name without comma, quote or control character";
  const ::toml::node& node = require(key, expected);
  if (!node.is_string()) refuse_type(key, node, expected);
  const std::string& text = node.as_string()->get();
  const bool is_bad = std::any_of(text.begin(), text.end(),
                                  [](char c) { return is_control(c) || c == ',' || c == '"'; });
  if (text.empty() || is_bad) refuse_at(key, node, expected);
  return text;
}

std::filesystem::path TableReader::file(std::string_view key) {
  constexpr std::string_view expected = "the path of a file";
  const ::toml::node& node = require(key, expected);
  if (!node.is_string()) refuse_type(key, node, expected);
  const std::string& text = node.as_string()->get();
  if (text.empty() || std::any_of(text.begin(), text.end(), is_control))
    refuse_at(key, node, expected);
  return folder() / text;
}

std::filesystem::path TableReader::folder() const {
  return std::filesystem::path(file_).parent_path();
}

bool TableReader::flag_or(std::string_view key, bool otherwise) {
  if (!has(key)) return otherwise;
  const ::toml::node& node = require(key, "true or false");
  if (!node.is_boolean()) refuse_type(key, node, "true or false");
  return node.as_boolean()->get();
}

std::size_t TableReader::choice(std::string_view key, std::span<const std::string_view> choices) {
  const std::string expected = "one of " + joined(choices);
  const ::toml::node& node = require(key, expected);
  if (!node.is_string()) refuse_type(key, node, expected);
  const auto found = std::find(choices.begin(), choices.end(), node.as_string()->get());
  if (found == choices.end()) {
    const auto meant = near_word(node.as_string()->get(), choices);
    refuse_at(key, node,
              meant ? expected + ": did you mean `" + std::string(*meant) + "`?" : expected);
  }
  return static_cast<std::size_t>(found - choices.begin());
}

TableReader TableReader::table(std::string_view key) {
  static const ::toml::table empty;
  const ::toml::node* node = find(key);
  if (node != nullptr) return table_at(key, *node);
  return {empty, file_, prefix_ + std::string(key) + ".", where_, owner_};
}

std::vector<TableReader> TableReader::tables(std::string_view key) {
  std::vector<TableReader> readers;
  if (!has(key)) return readers;
  for (const ::toml::node& node : require_array(key, "an array of tables")) {
    readers.push_back(table_at(key, node));
  }
  return readers;
}

void TableReader::refuse(std::string_view key, std::string_view expected) {
  refuse_at(key, require(key, expected), expected);
}

void TableReader::allow_only(std::span<const std::string_view> keys) {
  for (const std::string_view key : keys) asked_.emplace(key);
  finish();
}

void TableReader::refuse_gone(std::string_view key, std::string_view instead) const {
  if (const ::toml::node* node = table_->get(key))
    refuse_at(key, *node, "no such key: " + std::string(instead));
}

void TableReader::finish() const {
  const std::vector<std::string_view> asked(asked_.begin(), asked_.end());
  for (const auto& [key, value] : *table_) {
    if (asked_.contains(key.str())) continue;
    const auto where = key.source().begin;
    if (const auto meant = near_word(key.str(), asked))
      throw unknown_key(file_, where, prefix_, key.str(), value, *meant, owner_);
    throw scene_error(file_, where, prefix_ + std::string(key.str()), shown(value),
                      "no such key here, but " + joined(asked_) + owner_);
  }
}

const ::toml::node* TableReader::find(std::string_view key) {
  asked_.emplace(key);
  const ::toml::node* node = table_->get(key);
  if (node != nullptr) return node;
  // At once: what is read without it may be refused for its lack.
  for (const auto& [written, value] : *table_)
    if (!asked_.contains(written.str()) && is_near(written.str(), key))
      throw unknown_key(file_, written.source().begin, prefix_, written.str(), value, key, owner_);
  return nullptr;
}

const ::toml::node& TableReader::require(std::string_view key, std::string_view expected) {
  const ::toml::node* node = find(key);
  if (node == nullptr) {
    throw scene_error(file_, where_, prefix_ + std::string(key), "missing",
                      std::string(expected) + owner_);
  }
  return *node;
}

const ::toml::array& TableReader::require_array(std::string_view key, std::string_view expected) {
  const ::toml::node& node = require(key, expected);
  if (!node.is_array()) refuse_type(key, node, expected);
  return *node.as_array();
}

double TableReader::number_at(std::string_view key, const ::toml::node& node, Bound bound) const {
  if (!node.is_number()) refuse_type(key, node, numbers_within(bound));
  // Digits of another base are a slip where something is measured.
  if (node.is_integer() && node.as_integer()->flags() != ::toml::value_flags::none)
    refuse_at(key, node, std::string(numbers_within(bound)) + ", in decimal digits");
  const double value = node.value<double>().value_or(0.0);
  // Written so that NaN is refused.
  const bool is_within = value >= lowest_of(bound) && value <= kLargest;
  if (!is_within) refuse_at(key, node, numbers_within(bound));
  return value;
}

int TableReader::integer_at(std::string_view key, const ::toml::node& node,
                            IntegerRange range) const {
  if (!node.is_integer()) refuse_type(key, node, integers_within(range));
  const std::int64_t value = node.as_integer()->get();
  if (value < range.lowest || value > range.highest) refuse_at(key, node, integers_within(range));
  return static_cast<int>(value);
}

TableReader TableReader::table_at(std::string_view key, const ::toml::node& node) const {
  if (!node.is_table()) refuse_type(key, node, "a table");
  return {*node.as_table(), file_, prefix_ + std::string(key) + ".", node.source().begin, owner_};
}

void TableReader::refuse_at(std::string_view key, const ::toml::node& node,
                            std::string_view expected) const {
  throw scene_error(file_, node.source().begin, prefix_ + std::string(key), shown(node),
                    std::string(expected) + owner_);
}

void TableReader::refuse_type(std::string_view key, const ::toml::node& node,
                              std::string_view expected) const {
  refuse_at(key, node, std::string(expected) + ", found " + std::string(type_of(node)));
}

}  // namespace stillgrid::toml
