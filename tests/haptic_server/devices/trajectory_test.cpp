#include "haptic_server/devices/trajectory.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <locale>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/haptic_server/devices/recording_file.hpp"

namespace stillgrid::devices::trajectory_test {
namespace {

const std::string kSmall =
    "# tool: stylus\n"
    "time_s,x_m,y_m,z_m\n"
    "0.5,0.01,0.02,0.03\n"
    "0.75,-0.125,2e-2,0.0625\n"
    "1.0,0.013,0.021,0.031\n";

Trajectory read(const std::string& content, const TrajectoryOptions& options = {}) {
  const RecordingFile file(content);
  return read_trajectory(file.path(), options);
}

/// What is said about a bad file, without the file's name; empty when it is accepted.
std::string refusal(const std::string& content, const TrajectoryOptions& options = {}) {
  const RecordingFile file(content);
  try {
    static_cast<void>(read_trajectory(file.path(), options));
  } catch (const std::runtime_error& error) {
    const std::string line = error.what();
    REQUIRE(line.starts_with(file.path() + ":"));
    REQUIRE(line.find('\n') == std::string::npos);
    return line.substr(file.path().size() + 1);
  }
  return {};
}

TEST_CASE("A recording is read in metres, its time starting at zero", "[trajectory]") {
  const Trajectory trajectory = read(kSmall);

  REQUIRE(trajectory.time_s == std::vector<double>{0.0, 0.25, 0.5});
  CHECK(trajectory.position_m[1] == Eigen::Vector3d(-0.125, 0.02, 0.0625));
  CHECK(trajectory.orientation.empty());
  CHECK(trajectory.velocity_m_s.empty());
  CHECK(trajectory.force_N.empty());
}

TEST_CASE("A file cut off at any byte is read up to its last whole row", "[trajectory]") {
  const auto newlines = std::count(kSmall.begin(), kSmall.end(), '\n');
  for (std::size_t bytes = 0; bytes <= kSmall.size(); ++bytes) {
    const std::string cut = kSmall.substr(0, bytes);
    const auto rows = std::count(cut.begin(), cut.end(), '\n') - 2;  // metadata and header
    if (rows < 1) {
      CHECK(refusal(cut).find("no whole") != std::string::npos);
      continue;
    }
    const Trajectory trajectory = read(cut);
    CHECK(trajectory.time_s.size() == static_cast<std::size_t>(rows));
    CHECK(trajectory.position_m.front() == Eigen::Vector3d(0.01, 0.02, 0.03));
    if (rows == newlines - 2) CHECK(trajectory.position_m.back().x() == 0.013);
  }
}

TEST_CASE("A byte order mark, carriage returns, blanks and plus signs change nothing",
          "[trajectory]") {
  const Trajectory trajectory = read(
      "\xEF\xBB\xBF# tool: stylus\r\n time_s ,\tx_m, y_m ,z_m\r\n"
      "  0.5, +0.01,0.02\t,3.0E-2 \r\n\r\n 0.75 ,-0.125,+2e-02, 0.0625\r\n");
  REQUIRE(trajectory.time_s == std::vector<double>{0.0, 0.25});
  CHECK(trajectory.position_m[0] == Eigen::Vector3d(0.01, 0.02, 0.03));
  CHECK(trajectory.position_m[1] == Eigen::Vector3d(-0.125, 0.02, 0.0625));

  const std::string marked = "\xEF\xBB\xBFt_s,x_m,y_m,z_m\r\n0,0,0,1\r\n";
  for (std::size_t bytes = 0; bytes < marked.size(); ++bytes) {
    CHECK(refusal(marked.substr(0, bytes)).find("no whole") != std::string::npos);
  }
  CHECK(refusal(kSmall + "2,+-1,0,0\n").find("a finite number") != std::string::npos);
  CHECK(refusal(kSmall + "2,++1,0,0\n").find("a finite number") != std::string::npos);
  CHECK(refusal(kSmall + "2,+,0,0\n").find("a finite number") != std::string::npos);
}

TEST_CASE("A program's locale does not change what a recording says", "[trajectory]") {
  struct DecimalComma : std::numpunct<char> {
    [[nodiscard]] char do_decimal_point() const override { return ','; }
    [[nodiscard]] char do_thousands_sep() const override { return '.'; }
    [[nodiscard]] std::string do_grouping() const override { return "\3"; }
  };
  const std::locale before =
      std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
  const Trajectory trajectory = read(kSmall);
  std::locale::global(before);
  CHECK(trajectory.position_m[1] == Eigen::Vector3d(-0.125, 0.02, 0.0625));
}

TEST_CASE("Millimetres become metres", "[trajectory]") {
  const Trajectory trajectory = read("t_s,x_mm,y_m,z_mm\n0,12.345,0.5,-0.055\n");
  CHECK(trajectory.position_m[0] == Eigen::Vector3d(12.345 / 1000.0, 0.5, -0.055 / 1000.0));
}

TEST_CASE("Optional columns are read, others ignored whatever they hold", "[trajectory]") {
  const Trajectory trajectory = read(
      "note,fx_N,fy_N,fz_N,time_s,x_m,y_m,z_m,qw,qx,qy,qz,vx_m_s,vy_m_s,vz_m_s\r\n"
      "nan?,1,2,3,0,0,0,0,1.001,0,0,0,4,5,6\r\n\r\n");

  CHECK(trajectory.force_N.at(0) == Eigen::Vector3d(1, 2, 3));
  CHECK(trajectory.velocity_m_s.at(0) == Eigen::Vector3d(4, 5, 6));
  CHECK(trajectory.orientation.at(0).coeffs() == Eigen::Vector4d(0, 0, 0, 1));  // unit again
}

TEST_CASE("Of rows with equal stamps the last counts", "[trajectory]") {
  const Trajectory trajectory = read("t_s,x_m,y_m,z_m\n0,1,0,0\n0,2,0,0\n1,3,0,0\n1,4,0,0\n");
  REQUIRE(trajectory.time_s.size() == 2);
  CHECK(trajectory.position_m[0].x() == 2.0);
  CHECK(trajectory.position_m[1].x() == 4.0);
}

TEST_CASE("A bad row is named with file, line, column, value and what is expected",
          "[trajectory]") {
  const std::string header = "# by: hand\nt_s,x_m,y_m,z_m\n0,0,0,0\n";
  CHECK(refusal(header + "1,0,zwei,0\n") ==
        "4: column y_m: value 'zwei': expected a finite number");
  CHECK(refusal(header + "1,0,0,inf\n") == "4: column z_m: value 'inf': expected a finite number");
  CHECK(refusal(header + "nan,0,0,0\n") == "4: column t_s: value 'nan': expected a finite number");
  CHECK(refusal(header + "1,,0,0\n") == "4: column x_m: value '': expected a finite number");
  CHECK(refusal(header + "1,0x1,0,0\n") == "4: column x_m: value '0x1': expected a finite number");
  CHECK(refusal(header + "1,1e999,0,0\n").starts_with("4: column x_m: value '1e999'"));
  CHECK(refusal(header + "1,0,0\n") ==
        "4: column t_s: value '1': expected a row of 4 fields, not 3");
  CHECK(refusal(header + "1,0,0,0,0\n").find("not 5") != std::string::npos);
  CHECK(refusal(header + "2,0,0,0\n1,0,0,0\n") ==
        "5: column t_s: value '1': expected a time not before that of the row above");
  CHECK(refusal("t_s,x_m,y_m,z_m,qx,qy,qz,qw\n0,0,0,0,0,0,0,0\n").find("norm one") !=
        std::string::npos);
}

TEST_CASE("A header that lacks or repeats a column is refused by name", "[trajectory]") {
  CHECK(refusal("x_m,y_m,z_m\n0,0,0\n").starts_with("1: column time_s: missing"));
  CHECK(refusal("t_s,x_m,z_m\n0,0,0\n").starts_with("1: column y_m: missing"));
  CHECK(refusal("t_s,x_m,y_m,z_m,x_mm\n0,0,0,0,0\n").starts_with("1: column x_mm: given twice"));
  CHECK(refusal("t_s,x_m,y_m,z_m,qx,qy,qz\n0,0,0,0,0,0,0\n").starts_with("1: column qw: missing"));
}

TEST_CASE("A file that gzip has compressed is told so", "[trajectory]") {
  CHECK(refusal("\x1f\x8b\x08 of one line\n") ==
        " compressed by gzip: expected text, as gunzip makes");
}

TEST_CASE("A file that cannot be read is refused", "[trajectory]") {
  CHECK_THROWS_WITH(read_trajectory("/nowhere/at/all.csv"),
                    Catch::Contains("/nowhere/at/all.csv: cannot be read"));
  CHECK_THROWS_WITH(read_trajectory(std::filesystem::temp_directory_path().string()),
                    Catch::Contains("cannot be read"));
}

TEST_CASE("Positions are scaled and then offset, velocities scaled, forces left", "[trajectory]") {
  const TrajectoryOptions options{0.5, {1.0, 2.0, 3.0}, {}};
  const Trajectory trajectory =
      read("t_s,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,fx_N,fy_N,fz_N\n0,4,6,8,2,2,2,1,1,1\n", options);
  CHECK(trajectory.position_m[0] == Eigen::Vector3d(3.0, 5.0, 7.0));
  CHECK(trajectory.velocity_m_s[0] == Eigen::Vector3d(1.0, 1.0, 1.0));
  CHECK(trajectory.force_N[0] == Eigen::Vector3d(1.0, 1.0, 1.0));
  CHECK(refusal("t_s,x_m,y_m,z_m\n0,1e300,0,0\n", {1e300, {0.0, 0.0, 0.0}, {}})
            .find("finite length") != std::string::npos);
}

TEST_CASE("A map makes axes of columns, and leaves the others zero", "[trajectory]") {
  TrajectoryOptions options;
  options.map = parse_axis_map("z_m:slave_rad*0.5;x_m:lift_mm*1e-3");
  const Trajectory trajectory =
      read("t_s,slave_rad,lift_mm,vx_m_s,vy_m_s,vz_m_s\n0,-3,250,1,1,1\n", options);
  CHECK(trajectory.position_m[0] == Eigen::Vector3d(0.25, 0.0, -1.5));
  CHECK(trajectory.velocity_m_s.empty());

  options.map = parse_axis_map("x_m:absent");
  CHECK(refusal("t_s,y\n0,1\n", options) ==
        "1: column absent: missing: expected by the map of x_m");
}

TEST_CASE("A map that cannot be meant is refused", "[trajectory]") {
  for (const char* const text :
       {"", "x_m", "x_m:", "w_m:a", "x_m:a*", "x_m:a*two", "x_m:a;x_m:b", "x_m:a;", "x_m:*2"}) {
    CHECK_THROWS_WITH(parse_axis_map(text), Catch::Contains("expected AXIS:COLUMN[*FACTOR]"));
  }
}

TEST_CASE("Recordings made by others are read", "[trajectory][real_data]") {
  const auto folder = real_recordings();
  if (!std::filesystem::exists(folder)) {
    WARN("skipped: no recordings in " << folder);
    return;
  }
  const Trajectory franka =
      read_trajectory((folder / "franka_1khz" / "franka_20260223_162545.csv").string());
  CHECK(franka.time_s.size() > 10'000);
  CHECK(franka.orientation.size() == franka.time_s.size());

  const Trajectory contour =
      read_trajectory((folder / "ku_contour_force" / "demo_a_1.csv").string());
  CHECK(contour.position_m.front().isApprox(Eigen::Vector3d(-0.2394376, 0.194e-3, -0.1664e-3)));
  CHECK(contour.force_N.size() == contour.time_s.size());

  const TrajectoryOptions lever{1.0, {0.0, 0.0, 0.0}, parse_axis_map("x_m:slave_rad*0.075")};
  const Trajectory teleoperation =
      read_trajectory((folder / "teleop_1dof_2khz" / "m2_question1a_spring.csv").string(), lever);
  CHECK(teleoperation.time_s.front() == 0.0);
  CHECK(teleoperation.position_m.front().x() == Approx(-0.052569 * 0.075));

  CHECK_THROWS_WITH(read_trajectory((folder / "ku_contour_force" / "contour_edge_mm.csv").string()),
                    Catch::Contains("contour_edge_mm.csv:2: column time_s: missing"));
}

}  // namespace
}  // namespace stillgrid::devices::trajectory_test
