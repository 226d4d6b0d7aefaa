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

namespace stillgrid {
namespace {

/// A folder of this test's own, gone afterwards.
struct Folder {
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "whole_file_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no folder for the test");
    path = name;
  }
  ~Folder() { std::filesystem::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] auto files() const {
    return std::distance(std::filesystem::directory_iterator(path), {});
  }
  std::filesystem::path path;
};

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST_CASE("A file keeps what it held until the new one is whole", "[whole_file]") {
  const Folder folder;
  const auto file = folder.path / "a.csv";
  write_whole(file, [](std::ostream& out) { out << "old\n"; });
  write_whole(file, [&](std::ostream& out) {
    out << "new\n" << std::flush;
    CHECK(text_of(file) == "old\n");
  });
  CHECK(text_of(file) == "new\n");
  CHECK(folder.files() == 1);
}

TEST_CASE("Asking whether a file can be written leaves it as it was", "[whole_file]") {
  const Folder folder;
  const auto file = folder.path / "a.csv";
  require_writable(file);
  CHECK(folder.files() == 0);
  write_whole(file, [](std::ostream& out) { out << "old\n"; });
  require_writable(file);
  CHECK(text_of(file) == "old\n");
  CHECK(folder.files() == 1);
}

TEST_CASE("A file that cannot be written is named and leaves nothing behind", "[whole_file]") {
  const Folder folder;
  CHECK_THROWS_WITH(require_writable(folder.path), Catch::Contains("is a folder"));
  CHECK_THROWS_WITH(require_writable(folder.path / "no" / "a.csv"),
                    Catch::Contains("a.csv: cannot be written"));
  CHECK_THROWS_WITH(
      write_whole(folder.path / "a.csv", [](std::ostream& out) { out.setstate(std::ios::badbit); }),
      Catch::Contains("could not be written to its end"));
  CHECK_THROWS_AS(write_whole(folder.path / "a.csv", [](std::ostream&) { throw 1; }), int);
  CHECK(folder.files() == 0);
}

TEST_CASE("A pipe is written as it is", "[whole_file]") {
  const Folder folder;
  const auto pipe = folder.path / "pipe";
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  std::string read;
  std::thread reader([&] { read = text_of(pipe); });
  write_whole(pipe, [](std::ostream& out) { out << "through\n"; });
  reader.join();
  CHECK(read == "through\n");
  CHECK(folder.files() == 1);
}

}  // namespace
}  // namespace stillgrid
