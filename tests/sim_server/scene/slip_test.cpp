// Slips of the pen in the keys and values of a scene, drawn.
#include <catch2/catch.hpp>
#include <cctype>
#include <cstddef>
#include <random>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/sim_server/scene/full_scene.hpp"
#include "tests/sim_server/scene/temporary_scene.hpp"

namespace stillgrid::scene::slip_test {
namespace {

/// A key at the beginning of a line of the full scene, and whose it is.
struct Place {
  std::size_t line = 0;  // from zero
  std::string key;
  std::string owner;  // " (body 'ball')"
};

std::vector<std::string> lines_of_full_scene() {
  std::vector<std::string> lines;
  std::istringstream text{std::string(kFullScene)};
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

std::string text_of(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + '\n';
  return text;
}

/// Every key that begins a line below a table's head; the names of tables stand first in them.
std::vector<Place> places_of(const std::vector<std::string>& lines) {
  std::vector<Place> places;
  std::string table, owner;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::string& line = lines[i];
    if (line.front() == '[') {
      table = line.substr(line.find_last_of('[') + 1, line.find(']') - line.find_last_of('[') - 1);
      if (!table.starts_with("body.")) owner.clear();  // tables of a body are its own
      continue;
    }
    const std::string key = line.substr(0, line.find(' '));
    if (key == "name")
      owner = " (" + table + " '" + line.substr(line.find('"') + 1, line.rfind('"') - 8) + "')";
    else
      places.push_back({i, key, owner});
  }
  return places;
}

std::string stem_of(const std::string& key) {
  for (const std::string_view units :
       {"_N_per_m", "_N_s_per_m", "_rad_s", "_m_s2", "_m_s", "_kg", "_xyzw", "_hz", "_s", "_m"})
    if (key.ends_with(units)) return key.substr(0, key.size() - units.size());
  return key;
}

/// A slip of each kind; nothing where it would be the key itself.
std::vector<std::string> slips_of(const std::string& key, std::mt19937& random) {
  const std::string stem = stem_of(key), units = key.substr(stem.size());
  std::vector<std::string> slips;
  if (!units.empty()) slips.push_back(stem);
  if (units == "_m") slips.push_back(stem + "_mm");
  if (stem.size() < 4) return slips;
  const std::size_t at = 1 + random() % (stem.size() - 2);
  slips.push_back(stem.substr(0, at) + stem.substr(at + 1) + units);
  slips.push_back(stem.substr(0, at) + 'x' + stem.substr(at) + units);
  if (stem[at] != stem[at + 1]) {
    std::string swapped = stem;
    std::swap(swapped[at], swapped[at + 1]);
    slips.push_back(swapped + units);
  }
  std::string capital = key;
  capital[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(capital[0])));
  slips.push_back(capital);
  return slips;
}

}  // namespace

TEST_CASE("A key that was misspelt is named with the key that was meant, its line and its body",
          "[scene_file]") {
  const std::vector<std::string> lines = lines_of_full_scene();
  REQUIRE(refusal_of(text_of(lines)).empty());
  const std::vector<Place> places = places_of(lines);
  REQUIRE(places.size() > 50);
  for (const unsigned seed : {11U, 4711U, 90210U}) {
    std::mt19937 random(seed);
    for (const Place& place : places)
      for (const std::string& slip : slips_of(place.key, random)) {
        std::vector<std::string> misspelt = lines;
        misspelt[place.line].replace(0, place.key.size(), slip);
        const std::string refusal = refusal_of(text_of(misspelt));
        INFO(slip << " for " << place.key << ": " << refusal);
        CHECK(refusal.find(std::to_string(place.line + 1) + ":1: ") == 0);
        CHECK(refusal.ends_with(": unknown key `" + slip + "`: did you mean `" + place.key + "`?" +
                                place.owner));
      }
  }
}

TEST_CASE("No key of a scene is taken for a slip of another that is missing", "[scene_file]") {
  const std::vector<std::string> lines = lines_of_full_scene();
  std::size_t refused = 0;
  for (const Place& place : places_of(lines)) {
    std::vector<std::string> without = lines;
    without[place.line].clear();
    const std::string refusal = refusal_of(text_of(without));
    INFO(place.key << ": " << refusal);
    CHECK(refusal.find("did you mean") == std::string::npos);
    if (!refusal.empty()) ++refused;
  }
  CHECK(refused > 15);
}

TEST_CASE("A table that was misspelt is named with the table that was meant", "[scene_file]") {
  const std::string scene{kFullScene};
  for (const auto& [head, slip] : {std::pair<std::string, std::string>{"[world]", "worlds"},
                                   {"[simulation]", "simulaton"},
                                   {"[grid]", "gird"},
                                   {"[tool]", "tools"},
                                   {"[device]", "devices"},
                                   {"[[material]]", "materials"},
                                   {"[[body]]", "bodies"}}) {
    std::string text = scene;
    const std::string key = head.substr(head.rfind('[') + 1, head.find(']') - head.rfind('[') - 1);
    for (std::size_t at = text.find(head); at != std::string::npos; at = text.find(head, at + 1))
      text.replace(text.find(key, at), key.size(), slip);
    CHECK(refusal_of(text).find(": unknown table `" + slip + "`: did you mean `" + key + "`?") !=
          std::string::npos);
  }
  CHECK(refusal_of("format = 2\n[weather]\nwind = 1")
            .find("2:2: weather: value {...}: expected no "
                  "such key here, but body, ") == 0);
}

TEST_CASE("A value that is none of a key's is named with the one that was meant", "[scene_file]") {
  const std::string scene{kFullScene};
  for (const auto& [value, slip] :
       {std::pair<std::string, std::string>{"implicit_euler", "implict_euler"},
        {"soft_block", "softblock"},
        {"rigid_box", "box"},
        {"prescribed", "perscribed"},
        {"two_corners", "two_corner"},
        {"sheet", "sheets"}}) {
    std::string text = scene;
    text.replace(text.find('"' + value + '"'), value.size() + 2, '"' + slip + '"');
    const std::string refusal = refusal_of(text);
    INFO(refusal);
    CHECK(refusal.find(": value '" + slip + "': expected one of ") != std::string::npos);
    CHECK(refusal.find(": did you mean `" + value + "`?") != std::string::npos);
  }
  // What is like none of them is said to be like none.
  std::string text = scene;
  text.replace(text.find("\"sheet\""), 7, "\"jelly\"");
  CHECK(refusal_of(text).find("did you mean") == std::string::npos);
  CHECK(refusal_of(text).ends_with("sphere, plane, compound (body 'cloth')"));
}

}  // namespace stillgrid::scene::slip_test
