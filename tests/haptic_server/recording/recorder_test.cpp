#include "haptic_server/recording/recorder.hpp"

#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "haptic_server/recording/csv_recording.hpp"
#include "haptic_server/safety/safety_flag.hpp"
#include "shared/files/failing_writes.hpp"

namespace stillgrid::recording::recorder_test {
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

void remove_recording(const std::filesystem::path& file) {
  std::filesystem::remove(file);
  std::filesystem::remove(metadata_file(file));
}

/// Files of this process cannot grow beyond a size: a disk that is full from there on.
class FullDisk {
 public:
  explicit FullDisk(std::uintmax_t bytes) {
    files::make_writes_fail();
    spdlog::set_level(spdlog::level::off);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const ::rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() { ::setrlimit(RLIMIT_FSIZE, &before_); }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  ::rlimit before_{};
};

constexpr int kSnapshotIdColumn = 13;

/// Snapshots of the rows below the columns' names, each of which must be whole and later than the
/// one above.
std::vector<std::uint64_t> whole_rows(const std::filesystem::path& file) {
  std::vector<std::uint64_t> snapshots;
  auto lines = lines_of(file);
  for (std::size_t i = 1; i < lines.size(); ++i) {
    if (std::count(lines[i].begin(), lines[i].end(), ',') != 25)
      throw std::runtime_error("no whole row: " + lines[i]);
    std::size_t start = 0;
    for (int column = 0; column < kSnapshotIdColumn; ++column)
      start = lines[i].find(',', start) + 1;
    snapshots.push_back(std::stoull(lines[i].substr(start)));
    if (snapshots.size() > 1 && *(snapshots.end() - 2) >= snapshots.back())
      throw std::runtime_error("rows out of order at " + lines[i]);
  }
  return snapshots;
}

TickRow numbered(int i) {
  TickRow row;
  row.time_s = i * 1e-3;
  row.snapshot_id = static_cast<std::uint64_t>(i);
  return row;
}

void wait_for_size(const std::filesystem::path& file, std::uintmax_t bytes) {
  while (std::filesystem::file_size(file) != bytes)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

TEST_CASE("Every tick is a row, in order, none lost", "[recorder]") {
  const auto file = temporary_file();
  {
    Recorder recorder(file, "scene", "device");
    for (int i = 0; i < 50000; ++i) recorder.record_waiting(numbered(i));
    CHECK(recorder.finish() == 0);
  }
  const auto lines = lines_of(file);
  REQUIRE(lines.size() == 50001);
  for (std::size_t i = 1; i < lines.size(); i += 997)
    CHECK_THAT(lines[i], Catch::Contains("0," + std::to_string(i - 1) + ",1,0,0,0,"));
  remove_recording(file);
}

TEST_CASE("A number written reads back to the same bits", "[recorder]") {
  TickRow row;
  row.position_m = {0.1, 1.0 / 3.0, -2.2250738585072014e-308};
  std::string line;
  append_row(row, line);
  CHECK(line.rfind("0,0.1,0.3333333333333333,-2.2250738585072014e-308,", 0) == 0);
}

TEST_CASE("Flags are named, joined by bars, and followed by torque and orientation", "[recorder]") {
  TickRow row;
  row.tick_ns = 77;
  row.flags = safety::kFlagFaded | safety::kFlagClamped | safety::kFlagSwept;
  row.torque_N_m = {0.25, -1.0, 0.0};
  row.orientation = {0.5, -0.5, 0.5, 0.5};
  std::string line;
  append_row(row, line);
  CHECK_THAT(line, Catch::EndsWith(",77,faded|clamped|swept,0.25,-1,0,-0.5,0.5,0.5,0.5"));
}

TEST_CASE("A row has a field for each column, and columns known before keep their places",
          "[recorder]") {
  const auto file = temporary_file();
  {
    Recorder recorder(file, "scene", "device");
    recorder.record_waiting({});
  }
  const auto lines = lines_of(file);
  remove_recording(file);
  REQUIRE(lines.size() == 2);
  CHECK_THAT(lines[0], Catch::StartsWith("time_s,x_m,y_m,z_m,vx_m_s,") &&
                           Catch::EndsWith(",tick_ns,flags,tx_N_m,ty_N_m,tz_N_m,qx,qy,qz,qw"));
  CHECK(std::count(lines[1].begin(), lines[1].end(), ',') ==
        std::count(lines[0].begin(), lines[0].end(), ','));
}

TEST_CASE("A file that cannot be written is refused before the loop", "[recorder]") {
  CHECK_THROWS_AS(Recorder("/nowhere/at/all.csv", "s", "d"), std::runtime_error);
}

TEST_CASE("A disk that stays full leaves whole rows and a count of the others", "[recorder]") {
  const auto bytes = GENERATE(range(std::uintmax_t{3000}, std::uintmax_t{3060}));
  const auto file = temporary_file();
  constexpr int kRows = 500;
  const FullDisk full(bytes);
  Recorder recorder(file, "scene", "device");
  for (int i = 0; i < kRows; ++i) recorder.record(numbered(i));
  const std::uint64_t lost = recorder.finish();

  const auto rows = whole_rows(file);
  CHECK(lines_of(file).size() > 20);
  CHECK(rows.size() + lost == kRows);
  CHECK(std::filesystem::file_size(file) <= bytes);
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  in.seekg(-1, std::ios::end);
  CHECK(in.get() == '\n');
  remove_recording(file);
}

TEST_CASE("A disk that has room again has cost no row", "[recorder]") {
  const auto file = temporary_file();
  constexpr int kRows = 3000;
  Recorder recorder(file, "scene", "device");
  {
    const FullDisk full(40001);
    for (int i = 0; i < kRows; ++i) recorder.record(numbered(i));
    wait_for_size(file, 40001);  // in the middle of a row
  }
  CHECK(recorder.finish() == 0);
  CHECK(whole_rows(file).size() == kRows);
  remove_recording(file);
}

TEST_CASE("In lockstep too a full disk stops nothing, and every row is written or counted",
          "[recorder]") {
  const bool has_room_again = GENERATE(true, false);
  const auto file = temporary_file();
  constexpr int kRows = 60000;  // more than the ring holds
  Recorder recorder(file, "scene", "device");
  std::optional<FullDisk> full(50001);
  for (int i = 0; i < kRows; ++i) recorder.record_waiting(numbered(i));
  wait_for_size(file, 50001);
  if (has_room_again) full.reset();
  const std::uint64_t lost = recorder.finish();
  CHECK(lost > 0);
  CHECK((whole_rows(file).size() > 10000) == has_room_again);
  CHECK(whole_rows(file).size() + lost == kRows);
  remove_recording(file);
}

TEST_CASE("A ring that overflows counts what it could not take", "[recorder]") {
  const auto pipe = temporary_file();
  const auto copy = temporary_file() += ".copy";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  constexpr int kRows = 40000;
  std::atomic<bool> may_read = false;
  std::thread reader([&] {
    std::ifstream in(pipe, std::ios::binary);
    while (!may_read) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::ofstream(copy, std::ios::binary) << in.rdbuf();
  });
  Recorder recorder(pipe, "scene", "device");
  for (int i = 0; i < kRows; ++i) recorder.record(numbered(i));  // the writer hangs in the pipe
  may_read = true;
  const std::uint64_t lost = recorder.finish();
  reader.join();
  CHECK(lost > 0);
  CHECK(whole_rows(copy).size() + lost == kRows);
  std::filesystem::remove(pipe);
  std::filesystem::remove(copy);
}

TEST_CASE("A pipe whose reader has gone ends no process, and its rows are counted", "[recorder]") {
  files::make_writes_fail();
  const auto pipe = temporary_file();
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  std::thread reader([&] {
    std::ifstream in(pipe);
    std::string head;
    std::getline(in, head);
  });
  Recorder recorder(pipe, "scene", "device");
  reader.join();
  for (int i = 0; i < 100; ++i) recorder.record(numbered(i));
  CHECK(recorder.finish() == 100);
  std::filesystem::remove(pipe);
}

TEST_CASE("A head that finds no room is refused before the loop", "[recorder]") {
  const auto file = temporary_file();
  {
    const FullDisk full(50);
    CHECK_THROWS_WITH(Recorder(file, "scene", "device"), Catch::Contains("could not be written"));
  }
  CHECK_FALSE(std::filesystem::exists(file));
  CHECK_THROWS_WITH(Recorder("/dev/full", "scene", "device"),
                    "--record: /dev/full could not be written: No space left on device");
}

TEST_CASE("A CSV begins with its columns, and its metadata stand beside it", "[recorder]") {
  const auto file = temporary_file();
  {
    Recorder recorder(file, "two\nlines", "a\x1b[31mdevice", {{"device_serial", "7\r"}});
    recorder.record({});
  }
  const auto lines = lines_of(file);
  const auto metadata = nlohmann::json::parse(std::ifstream(metadata_file(file)));
  remove_recording(file);
  REQUIRE(lines.size() == 2);
  CHECK_THAT(lines[0], Catch::StartsWith("time_s,"));
  CHECK(metadata.at("url") == file.filename().string());
  const nlohmann::json notes = metadata.at("notes").at(0);
  CHECK(notes.at("scene") == "two lines");
  CHECK(notes.at("device") == "a [31mdevice");
  CHECK(notes.at("device_serial") == "7 ");
}

}  // namespace
}  // namespace stillgrid::recording::recorder_test
