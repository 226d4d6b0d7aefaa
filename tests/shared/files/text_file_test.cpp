#include "shared/files/text_file.hpp"

#include <sys/resource.h>
#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <stdexcept>

#include "tests/test_folder.hpp"

namespace stillgrid::files::text_file_test {
namespace {

/// The refusal, without the file's name.
std::string refusal(const std::filesystem::path& file, std::uintmax_t most_bytes = kMiB) {
  try {
    static_cast<void>(read_text(file, most_bytes));
  } catch (const std::runtime_error& error) {
    const std::string line = error.what(), name = file.string() + ": ";
    REQUIRE(line.starts_with(name));
    return line.substr(name.size());
  }
  return "";
}

std::filesystem::path file_of(const tests::TestFolder& folder, const std::string& content) {
  const auto file = folder.path / "a.csv";
  std::ofstream(file, std::ios::binary) << content;
  return file;
}

TEST_CASE("A text is read byte for byte, an empty one too", "[text_file]") {
  const tests::TestFolder folder;
  const std::string text =
      GENERATE(std::string(), std::string("a\r\nb\n"), std::string(200'000, 'x') + "\xC3\xA4");
  CHECK(read_text(file_of(folder, text), kMiB) == text);
}

TEST_CASE("A file that is missing, a folder, a pipe or a device is refused at once",
          "[text_file]") {
  const tests::TestFolder folder;
  const auto pipe = folder.path / "pipe";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  CHECK(refusal(folder.path / "none.csv") == "cannot be read: No such file or directory");
  for (const auto& file : {folder.path, pipe, std::filesystem::path("/dev/zero")})
    CHECK(refusal(file) == "cannot be read: expected a regular file");
}

TEST_CASE("A file above the limit is refused, one of just that size is read", "[text_file]") {
  const tests::TestFolder folder;
  const auto file = file_of(folder, std::string(kMiB, 'x'));
  CHECK(refusal(file).empty());
  std::ofstream(file, std::ios::app) << 'x';
  CHECK(refusal(file) == "cannot be read: expected at most 1 MiB");
}

TEST_CASE("A sparse file is refused at its first hole, in little memory", "[text_file]") {
  const tests::TestFolder folder;
  const auto file = file_of(folder, "time_s,x_m\n");
  constexpr std::uintmax_t kSize = 1024 * kMiB;
  std::filesystem::resize_file(file, kSize);
  rusage before{}, after{};
  ::getrusage(RUSAGE_SELF, &before);
  CHECK(refusal(file, kSize) == "cannot be read: expected text, found a zero byte");
  ::getrusage(RUSAGE_SELF, &after);
  CHECK(after.ru_maxrss - before.ru_maxrss < 50'000);  // kB
}

TEST_CASE("A packed file is named as what it is", "[text_file]") {
  const tests::TestFolder folder;
  CHECK(refusal(file_of(folder, std::string("\x89MCAP0\r\n\0", 9))) ==
        "an MCAP file: expected CSV, as stillgrid_import makes");
  CHECK(refusal(file_of(folder, std::string("\x1f\x8b\x08\0", 4))) ==
        "compressed by gzip: expected text, as gunzip makes");
}

}  // namespace
}  // namespace stillgrid::files::text_file_test
