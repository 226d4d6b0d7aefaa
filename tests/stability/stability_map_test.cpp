#include "tests/laboratory/stability_map.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace stillgrid::laboratory::stability_map_test {
namespace {

TEST_CASE("A map has every combination once, and none that cannot be", "[stability_map]") {
  StabilityMap map;
  map.scenes = {"wall", "free:0.5", "pinch"};
  map.froms = {"inside", "outside"};
  map.models = {"grid", "proxy"};
  map.transitions = {"local", "hold"};
  const std::vector<LabCell> cells = cells_of(map);
  CHECK(cells.size() == 4 * 3);  // the wall from both sides; grid with two transitions, one without
  CHECK(std::none_of(cells.begin(), cells.end(), [](const LabCell& cell) {
    return (cell.from == "outside" && cell.scene != "wall") ||
           (cell.model == "proxy" && cell.transition != "local");
  }));
}

std::vector<std::string> lines_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST_CASE("A map that was stopped goes on with the rows that are missing", "[stability_map]") {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "stability_map.csv";
  std::filesystem::remove(file);
  StabilityMap map;
  map.common.duration_s = 3.0;
  map.common.seeds = 2;
  map.jitters = {0.3};
  map.devices = {"light", "hand"};
  const StiffnessSearch search{.lowest_N_per_m = 6000.0, .highest_N_per_m = 16000.0, .step = 1.2};
  draw_map(map, search, 2, file);
  const std::vector<std::string> lines = lines_of(file);
  REQUIRE(lines.size() == 3);
  CHECK(std::count(lines[1].begin(), lines[1].end(), ',') ==
        std::count(lines[0].begin(), lines[0].end(), ','));
  CHECK(lines[1].find(",swings,") != std::string::npos);

  // The last row was being written when it was stopped; the first is as no run would make it.
  const std::string kept = lines[1].substr(0, lines[1].rfind(',')) + ",1e6";
  std::ofstream(file) << lines[0] << '\n' << kept << '\n' << lines[2].substr(0, 20);
  draw_map(map, search, 1, file);
  const std::vector<std::string> again = lines_of(file);
  REQUIRE(again.size() == 3);
  CHECK(again[1] == kept);
  CHECK(again[2].substr(0, again[2].rfind(',')) == lines[2].substr(0, lines[2].rfind(',')));

  // Whatever is wrong with a row, it is named, and the file stays as it is.
  for (const std::string& wrong :
       {std::string("abc"), lines[1].substr(0, 40), lines[1] + ",1", "1," + lines[1],
        lines[1].substr(0, lines[1].rfind(',')) + ",x"}) {
    const std::string text = lines[0] + '\n' + lines[2] + '\n' + wrong + '\n';
    std::ofstream(file) << text;
    CHECK_THROWS_WITH(draw_map(map, search, 1, file), Catch::Contains(".csv:3: value '" + wrong));
    std::stringstream left;
    left << std::ifstream(file).rdbuf();
    CHECK(left.str() == text);
  }
  CHECK_THROWS_WITH(draw_map(map, search, 1, file.parent_path()), Catch::Contains("not a folder"));

  std::ofstream(file) << "scene,limit\n";
  CHECK_THROWS_WITH(draw_map(map, search, 1, file), Catch::Contains("expected the columns"));
  std::filesystem::remove(file);
}

TEST_CASE("A cell's limit has what lost the next point, and that of other seeds",
          "[stability_map]") {
  LabCell cell;
  cell.scene = "pinch";
  cell.transition = "linear";
  cell.period_s = 0.033;
  cell.jitter = 0.3;
  cell.seeds = 2;
  const CellLimit found = limit_of(cell, {.lowest_N_per_m = 1000.0, .step = 1.1});
  REQUIRE(found.limit_N_per_m);
  REQUIRE(found.by_others_N_per_m);
  CHECK(*found.limit_N_per_m > 1000.0);
  CHECK(*found.limit_N_per_m < 10000.0);
  CHECK(found.lost_by == Verdict::kSwings);
  CHECK(*found.by_others_N_per_m > 0.69 * *found.limit_N_per_m);
  CHECK(*found.by_others_N_per_m < 1.41 * *found.limit_N_per_m);
  cell.scene = "wall";
  const CellLimit all = limit_of(cell, {.lowest_N_per_m = 1000.0, .highest_N_per_m = 1500.0});
  CHECK(all.lost_by == Verdict::kStable);
}

}  // namespace
}  // namespace stillgrid::laboratory::stability_map_test
