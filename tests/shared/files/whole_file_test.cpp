#include "shared/files/whole_file.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <ostream>
#include <stdexcept>
#include <string>
#include <thread>

#include "tests/test_folder.hpp"

namespace stillgrid::files::whole_file_test {
namespace {

auto files_in(const tests::TestFolder& folder) {
  return std::distance(std::filesystem::directory_iterator(folder.path), {});
}

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST_CASE("A file keeps what it held until the new one is whole", "[whole_file]") {
  const tests::TestFolder folder;
  const auto file = folder.path / "a.csv";
  write_whole(file, [](std::ostream& out) { out << "old\n"; });
  write_whole(file, [&](std::ostream& out) {
    out << "new\n" << std::flush;
    CHECK(text_of(file) == "old\n");
  });
  CHECK(text_of(file) == "new\n");
  CHECK(files_in(folder) == 1);
}

TEST_CASE("Asking whether a file can be written leaves it as it was", "[whole_file]") {
  const tests::TestFolder folder;
  const auto file = folder.path / "a.csv";
  require_writable(file);
  CHECK(files_in(folder) == 0);
  write_whole(file, [](std::ostream& out) { out << "old\n"; });
  require_writable(file);
  CHECK(text_of(file) == "old\n");
  CHECK(files_in(folder) == 1);
}

TEST_CASE("A pipe that nobody reads is asked without a wait", "[whole_file]") {
  const tests::TestFolder folder;
  const auto pipe = folder.path / "pipe";
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  require_writable(pipe);
  CHECK(std::filesystem::is_fifo(pipe));
}

TEST_CASE("A file that cannot be written is named and leaves nothing behind", "[whole_file]") {
  const tests::TestFolder folder;
  CHECK_THROWS_WITH(require_writable(folder.path), Catch::Contains("is a folder"));
  CHECK_THROWS_WITH(require_writable(folder.path / "no" / "a.csv"),
                    Catch::Contains("a.csv: cannot be written"));
  CHECK_THROWS_WITH(
      write_whole(folder.path / "a.csv", [](std::ostream& out) { out.setstate(std::ios::badbit); }),
      Catch::Contains("could not be written to its end"));
  CHECK_THROWS_AS(write_whole(folder.path / "a.csv", [](std::ostream&) { throw 1; }), int);
  CHECK(files_in(folder) == 0);
}

TEST_CASE("A pipe is written as it is", "[whole_file]") {
  const tests::TestFolder folder;
  const auto pipe = folder.path / "pipe";
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  std::string read;
  std::thread reader([&] { read = text_of(pipe); });
  write_whole(pipe, [](std::ostream& out) { out << "through\n"; });
  reader.join();
  CHECK(read == "through\n");
  CHECK(files_in(folder) == 1);
}

}  // namespace
}  // namespace stillgrid::files::whole_file_test
