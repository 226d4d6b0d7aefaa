#include "sim_server/spheres/sphere_file.hpp"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>

namespace stillgrid::spheres::sphere_file_test {
namespace {

using Catch::Contains;

std::filesystem::path file_with(const std::string& text) {
  const auto file = std::filesystem::temp_directory_path() /
                    ("stillgrid_sphere_file_test_" + std::to_string(getpid()) + ".csv");
  std::ofstream(file) << text;
  return file;
}

TEST_CASE("Spheres read back as they were written, to the bit", "[sphere_file]") {
  const auto file = file_with("what stood there before");
  const std::vector<Ball> balls = {{{0.1, -1.0 / 3.0, 1e-17}, 2.0 / 7.0},
                                   {{1e3, 2e-3, -0.0}, 5e-9}};
  write_spheres(balls, file);
  const std::vector<Ball> read = read_spheres(file);
  REQUIRE(read.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(read[i].centre_m == balls[i].centre_m);
    CHECK(read[i].radius_m == balls[i].radius_m);
  }
  CHECK_FALSE(std::filesystem::exists(file.string() + ".part"));
  std::filesystem::remove(file);
}

TEST_CASE("A file of spheres that cannot be meant is refused with line and value",
          "[sphere_file]") {
  const auto refusal = [](const std::string& text) {
    const auto file = file_with(text);
    std::string what = "none";
    try {
      (void)read_spheres(file);
    } catch (const std::runtime_error& error) {
      what = error.what();
    }
    std::filesystem::remove(file);
    return what;
  };
  const std::string header = "# made by hand\nx_m,y_m,z_m,radius_m\n";
  CHECK(refusal(header + "0,0,0,1\r\n\n") == "none");
  CHECK(refusal(header + "0,0,0,1") == "none");
  CHECK(refusal("note,radius_mm,x_mm,y_m,z_m\nfirst,5,0,0,0\n") == "none");
  CHECK_THAT(refusal("x,y,z,r\n0,0,0,1\n"), Contains(":1: column x_m: missing"));
  CHECK_THAT(refusal(header + "0,0,0\n"),
             Contains(":3: column x_m") && Contains("4 fields, not 3"));
  CHECK_THAT(refusal(header + "0,0,0,1,2\n"), Contains("4 fields, not 5"));
  CHECK_THAT(refusal(header + "0,nan,0,1\n"), Contains(":3: column y_m: value 'nan'"));
  CHECK_THAT(refusal(header + "0,0,0,0\n"), Contains("radius_m") && Contains("more than 0"));
  CHECK_THAT(refusal(header), Contains("0 spheres"));
  CHECK_THROWS_WITH(read_spheres("/nowhere/a.csv"), Contains("/nowhere/a.csv: cannot be read"));
  CHECK_THROWS_WITH(write_spheres({}, "/nowhere/a.csv"), Contains("cannot be written"));
}

TEST_CASE("A comment stands first in a file and is passed over when it is read", "[sphere_file]") {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("commented_" + std::to_string(getpid()) + ".csv");
  write_spheres(std::vector<Ball>{{{1.0, 2.0, 3.0}, 0.5}}, file, "softness_m = 0.25");
  std::string first;
  std::getline(std::ifstream(file) >> std::ws, first);
  CHECK(first == "# softness_m = 0.25");
  CHECK(read_spheres(file).size() == 1);
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace stillgrid::spheres::sphere_file_test
