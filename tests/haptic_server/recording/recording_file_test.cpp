// What becomes of the file that a recorder is given.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "haptic_server/recording/csv_recording.hpp"
#include "haptic_server/recording/recorder.hpp"
#include "tests/test_folder.hpp"

namespace stillgrid::recording::recording_file_test {
namespace {

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST_CASE("An earlier recording stays until a row is recorded, and no new file without one",
          "[recording_file]") {
  const tests::TestFolder folder;
  const std::string name = GENERATE("run.csv", "run.mcap");
  const auto file = folder.path / name;
  const auto never_begin = [&] {
    Recorder recorder(file, "scene", "device");
    CHECK(recorder.finish() == 0);
  };
  never_begin();
  CHECK_FALSE(std::filesystem::exists(file));
  CHECK_FALSE(std::filesystem::exists(metadata_file(file)));

  const std::string before = "the one before\n";
  folder.write(name, before);
  folder.write(metadata_file(name), before);
  never_begin();
  CHECK(text_of(file) == before);
  CHECK(text_of(metadata_file(file)) == before);

  {
    Recorder recorder(file, "scene", "device");
    recorder.record({});
    CHECK(recorder.finish() == 0);
  }
  CHECK_THAT(text_of(file), !Catch::Matchers::StartsWith(before));
}

TEST_CASE("Metadata that could not be written are refused before the loop, and no file is left",
          "[recording_file]") {
  const tests::TestFolder folder;
  const auto file = folder.path / "run.csv";
  std::filesystem::create_directory(metadata_file(file));
  CHECK_THROWS_WITH(Recorder(file, "s", "d"), "--record: " + metadata_file(file).string() +
                                                  ": cannot be written: is a folder");
  CHECK_FALSE(std::filesystem::exists(file));
}

TEST_CASE("A name says the form, in letters of any size, and none that a recording has not",
          "[recording_file]") {
  const tests::TestFolder folder;
  const auto begins = [&](const char* name) {
    { Recorder(folder.path / name, "s", "d").record({}); }
    return text_of(folder.path / name).substr(0, 5);
  };
  CHECK(begins("run.MCAP") == "\x89MCAP");
  CHECK(begins("run.Csv") == "time_");
  CHECK(begins("run") == "time_");
  for (const char* const name : {"run.csv", "run.MCAP", "run", "/dev/full", "run.gz/run.csv"})
    CHECK(name_complaint(name).empty());
  for (const std::string name : {"run.csv.gz", "run.mcap.GZ", "a.txt", ""})
    CHECK_THAT(name_complaint(name),
               Catch::Matchers::StartsWith("value '" + name + "': expected FILE.csv or FILE.mcap"));
}

}  // namespace
}  // namespace stillgrid::recording::recording_file_test
