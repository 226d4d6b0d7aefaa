#include "tests/laws/scene_text.hpp"

#include <algorithm>
#include <cstdio>
#include <sstream>

namespace stillgrid::laws {
namespace {

std::string without_ends(const std::string& line) {
  const auto first = line.find_first_not_of(" \t\r");
  if (first == std::string::npos) return {};
  return line.substr(first, line.find_last_not_of(" \t\r") - first + 1);
}

/// A comment that ends a line; scenes of laws hold no '#' in a name.
std::string without_comment(const std::string& line) {
  return without_ends(line.substr(0, line.find('#')));
}

}  // namespace

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  std::string number = text;
  // TOML tells whole numbers from others.
  if (number.find_first_of(".en") == std::string::npos) number += ".0";
  return number;
}

void SceneSection::set(std::string_view key, std::string_view value) {
  lines.push_back(std::string(key) + " = " + std::string(value));
}

void SceneSection::number(std::string_view key, double value) {
  set(key, short_number(value));
}

void SceneSection::text(std::string_view key, std::string_view value) {
  set(key, '"' + std::string(value) + '"');
}

void SceneSection::vector(std::string_view key, const Eigen::Vector3d& value) {
  set(key, "[" + short_number(value.x()) + ", " + short_number(value.y()) + ", " +
               short_number(value.z()) + "]");
}

std::string SceneSection::value_of(std::string_view key) const {
  for (const std::string& line : lines) {
    const auto equals = line.find('=');
    if (equals != std::string::npos && without_ends(line.substr(0, equals)) == key)
      return without_ends(line.substr(equals + 1));
  }
  return {};
}

SceneSection& SceneText::section(std::string_view head) {
  const auto found = std::find_if(sections.begin(), sections.end(),
                                  [head](const SceneSection& each) { return each.head == head; });
  return found != sections.end() ? *found : add(head);
}

SceneSection& SceneText::add(std::string_view head) {
  return sections.emplace_back(SceneSection{std::string(head), {}});
}

std::string SceneText::print() const {
  std::string text;
  for (const SceneSection& section : sections) {
    if (section.lines.empty()) continue;
    if (!section.head.empty()) text += section.head + '\n';
    for (const std::string& line : section.lines) text += line + '\n';
  }
  return text;
}

SceneText parse_scene_text(const std::string& text) {
  SceneText scene;
  scene.add("");
  std::istringstream stream(text);
  for (std::string raw; std::getline(stream, raw);) {
    const std::string line = without_comment(raw);
    if (line.empty()) continue;
    if (line.front() == '[')
      scene.add(line);
    else
      scene.sections.back().lines.push_back(line);
  }
  return scene;
}

}  // namespace stillgrid::laws
