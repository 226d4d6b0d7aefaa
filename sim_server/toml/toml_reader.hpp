#pragma once

#include <toml++/toml.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim_server/toml/scene_error.hpp"

namespace stillgrid::toml {

/// Which numbers a key takes. The ends keep a number and its square finite, and a positive
/// number positive, in a float.
enum class Bound {
  kAny,          // -1e12 to 1e12
  kNotNegative,  // 0 to 1e12
  kPositive,     // 1e-9 to 1e12
};

/// Whole numbers a key takes, both ends included.
struct IntegerRange {
  int lowest = 0;
  int highest = 0;
};

/// One table of a scene file, read key by key; each reading throws SceneError at the value
/// when it is not what was asked for.
///
/// Invariant: every key asked for is noted, found or not, so that finish() knows the keys
/// of a table from the code that reads them. The document must outlive its readers.
///
/// A refusal names whose table it is, by the nearest `name` outwards. A key that was not asked for
/// yet is refused as a slip when one is asked for that is near to it (near_word.hpp) and not there:
/// of two keys of a table that are near, the reader asks first for the one that may be there alone.
class TableReader {
 public:
  /// A reader of a whole document.
  TableReader(const ::toml::table& document, std::string file);

  /// Whether the key is there.
  [[nodiscard]] bool has(std::string_view key);
  /// Whether the key is there and holds a string.
  [[nodiscard]] bool has_text(std::string_view key);
  /// Whether the key is there and holds a number.
  [[nodiscard]] bool has_number(std::string_view key);
  /// Whether the key is there and holds a table.
  [[nodiscard]] bool has_table(std::string_view key);

  /// Whether the key is there and holds an array that is not empty.
  [[nodiscard]] bool has_tables(std::string_view key);

  [[nodiscard]] double number(std::string_view key, Bound bound);
  [[nodiscard]] double number_or(std::string_view key, Bound bound, double otherwise);
  [[nodiscard]] std::vector<double> numbers(std::string_view key, std::size_t count, Bound bound);

  [[nodiscard]] int integer(std::string_view key, IntegerRange range);
  /// Any number of them.
  [[nodiscard]] std::vector<int> integers(std::string_view key, IntegerRange range);

  [[nodiscard]] Eigen::Vector3d vector(std::string_view key, Bound bound = Bound::kAny);
  /// One to 16 of them.
  [[nodiscard]] std::vector<Eigen::Vector3d> vectors(std::string_view key);
  [[nodiscard]] Eigen::Vector3d vector_or(std::string_view key, const Eigen::Vector3d& otherwise);
  /// A vector that is not zero, made unit.
  [[nodiscard]] Eigen::Vector3d direction(std::string_view key);
  /// A quaternion x, y, z, w within 1e-3 of unit, made unit; the identity when missing.
  [[nodiscard]] Eigen::Quaterniond orientation_or_identity(std::string_view key);

  /// A string that can name a thing in a report: not empty, without comma, quote or control
  /// character.
  [[nodiscard]] std::string name(std::string_view key);
  /// The path of a file, from the folder of the scene file if it is relative.
  [[nodiscard]] std::filesystem::path file(std::string_view key);
  /// Where relative paths begin: the folder of the scene file, empty where that is the current one.
  [[nodiscard]] std::filesystem::path folder() const;
  [[nodiscard]] bool flag_or(std::string_view key, bool otherwise);
  /// The index of the string among the choices.
  [[nodiscard]] std::size_t choice(std::string_view key, std::span<const std::string_view> choices);

  /// The table under the key; an empty one, standing where this one stands, when missing.
  [[nodiscard]] TableReader table(std::string_view key);
  /// The tables of an array; none when missing.
  [[nodiscard]] std::vector<TableReader> tables(std::string_view key);

  /// Throws at the value of the key, or at the table when the key is missing.
  [[noreturn]] void refuse(std::string_view key, std::string_view expected);

  /// Throws at the value of a key of earlier versions, if it is there. instead: the words that
  /// follow "no such key: ".
  void refuse_gone(std::string_view key, std::string_view instead) const;

  /// The line that the table begins at, from one.
  [[nodiscard]] unsigned line() const noexcept { return where_.line; }

  /// Throws at a key that is none of these, before any is read.
  void allow_only(std::span<const std::string_view> keys);

  /// Throws at a key that nobody asked for. Call it once everything was read.
  void finish() const;

 private:
  TableReader(const ::toml::table& table, std::string file, std::string prefix,
              ::toml::source_position where, const std::string& owner);

  [[nodiscard]] const ::toml::node* find(std::string_view key);
  [[nodiscard]] const ::toml::node& require(std::string_view key, std::string_view expected);
  [[nodiscard]] const ::toml::array& require_array(std::string_view key, std::string_view expected);
  [[nodiscard]] double number_at(std::string_view key, const ::toml::node& node, Bound bound) const;
  [[nodiscard]] int integer_at(std::string_view key, const ::toml::node& node,
                               IntegerRange range) const;
  [[nodiscard]] TableReader table_at(std::string_view key, const ::toml::node& node) const;
  [[noreturn]] void refuse_at(std::string_view key, const ::toml::node& node,
                              std::string_view expected) const;
  [[noreturn]] void refuse_type(std::string_view key, const ::toml::node& node,
                                std::string_view expected) const;

  const ::toml::table* table_;
  std::string file_;
  std::string prefix_;  // of the table's keys in messages: "body.spheres."
  ::toml::source_position where_;
  std::string owner_;  // ends a refusal: " (body 'ball')"; empty: nobody's
  std::set<std::string, std::less<>> asked_;
};

}  // namespace stillgrid::toml
