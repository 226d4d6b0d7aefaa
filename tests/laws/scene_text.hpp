#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

namespace stillgrid::laws {

/// A table of a scene file, a key a line.
struct SceneSection {
  std::string head;  // "[tool]", "[[body]]"; empty: what stands before the first
  std::vector<std::string> lines;

  void set(std::string_view key, std::string_view value);
  void number(std::string_view key, double value);
  void text(std::string_view key, std::string_view value);
  void vector(std::string_view key, const Eigen::Vector3d& value);
  /// What stands behind the key; empty where it does not.
  [[nodiscard]] std::string value_of(std::string_view key) const;
};

/// A scene file as text that can be taken apart: what is drawn, shrunk and kept.
struct SceneText {
  std::vector<SceneSection> sections;

  /// The section of that head, appended if there is none.
  [[nodiscard]] SceneSection& section(std::string_view head);
  /// Another one of that head: a reference until the next call.
  SceneSection& add(std::string_view head);
  [[nodiscard]] std::string print() const;
};

/// Splits a file that has a key a line; blank lines and comments go.
[[nodiscard]] SceneText parse_scene_text(const std::string& text);

/// Four digits, which are what a scene of hand-made sizes needs.
[[nodiscard]] std::string short_number(double value);

}  // namespace stillgrid::laws
