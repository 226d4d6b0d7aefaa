#include "haptic_server/recording/recorder.hpp"

#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "haptic_server/safety/force_guard.hpp"

namespace stillgrid {
namespace {

std::filesystem::path temporary_file() {
  return std::filesystem::temp_directory_path() /
         ("stillgrid-recorder-" + std::to_string(::getpid()) + ".csv");
}

std::vector<std::string> lines_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST_CASE("Every tick is a row, in order, none lost", "[recorder]") {
  const auto file = temporary_file();
  {
    Recorder recorder(file, "scene", "device");
    for (int i = 0; i < 50000; ++i) {
      TickRow row;
      row.time_s = i * 1e-3;
      row.generation = static_cast<std::uint64_t>(i);
      recorder.record_waiting(row);
    }
    CHECK(recorder.finish() == 0);
  }
  const auto lines = lines_of(file);
  REQUIRE(lines.size() == 50003);
  CHECK(lines[0] == "# scene: scene");
  for (std::size_t i = 3; i < lines.size(); i += 997)
    CHECK_THAT(lines[i], Catch::Matchers::Contains("0," + std::to_string(i - 3) + ",1,0,0,0,"));
  std::filesystem::remove(file);
}

TEST_CASE("A number written reads back to the same bits", "[recorder]") {
  TickRow row;
  row.position_m = {0.1, 1.0 / 3.0, -2.2250738585072014e-308};
  std::string line;
  append_row(row, line);
  CHECK(line.rfind("0,0.1,0.3333333333333333,-2.2250738585072014e-308,", 0) == 0);
}

TEST_CASE("Flags are named, joined by bars, and followed by the torque", "[recorder]") {
  TickRow row;
  row.tick_ns = 77;
  row.flags = kFlagFaded | kFlagClamped | kFlagSwept;
  row.torque_N_m = {0.25, -1.0, 0.0};
  std::string line;
  append_row(row, line);
  CHECK_THAT(line, Catch::Matchers::EndsWith(",77,faded|clamped|swept,0.25,-1,0"));
}

TEST_CASE("A row has a field for each column, and columns known before keep their places",
          "[recorder]") {
  const auto file = temporary_file();
  {
    Recorder recorder(file, "scene", "device");
    recorder.record_waiting({});
  }
  const auto lines = lines_of(file);
  std::filesystem::remove(file);
  REQUIRE(lines.size() == 4);
  CHECK_THAT(lines[2], Catch::Matchers::StartsWith("time_s,x_m,y_m,z_m,vx_m_s,") &&
                           Catch::Matchers::EndsWith(",tick_ns,flags,tx_Nm,ty_Nm,tz_Nm"));
  CHECK(std::count(lines[3].begin(), lines[3].end(), ',') ==
        std::count(lines[2].begin(), lines[2].end(), ','));
}

TEST_CASE("A file that cannot be written is refused before the loop", "[recorder]") {
  CHECK_THROWS_AS(Recorder("/nowhere/at/all.csv", "s", "d"), std::runtime_error);
}

}  // namespace
}  // namespace stillgrid
