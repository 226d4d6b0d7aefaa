#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/haptic_server/devices/plugin.hpp"
#include "tests/haptic_server/devices/recording_file.hpp"

namespace stillgrid::devices::replay_test {
namespace {

TEST_CASE("A recording is replayed from zero and comes to its end", "[plugins]") {
  const RecordingFile file(kRecording);
  Plugin replay("replay");
  REQUIRE(replay.configure("file", file.path()) == STILLGRID_DEVICE_OK);
  REQUIRE(replay.configure("scale", "0.5") == STILLGRID_DEVICE_OK);
  REQUIRE(replay.configure("offset_z_m", "-0.5") == STILLGRID_DEVICE_OK);
  CHECK(replay.describe().max_force_N == 0.0);
  CHECK(replay.describe().workspace_max_m[1] == 0.0);  // where a hand went is no edge of hardware
  CHECK(std::string(replay.identity().serial) == std::filesystem::path(file.path()).filename());

  constexpr std::uint64_t kStart_ns = 77 * kTick_ns;
  for (int round = 0; round < 2; ++round) {  // activating again starts again
    REQUIRE(replay.api.activate(replay.device) == STILLGRID_DEVICE_OK);
    for (std::uint64_t n = 0; n <= 4; ++n) {
      REQUIRE(replay.read(kStart_ns + n * kTick_ns) == STILLGRID_DEVICE_OK);
      const double x_m = 0.1 * std::min(static_cast<double>(n) / 2.0, 1.0);
      CHECK(replay.state.position_m[0] == Approx(x_m).margin(1e-12));
      CHECK(replay.state.position_m[2] == 0.0);
      CHECK(replay.state.sequence == n + 1);
    }
    CHECK(replay.read(kStart_ns + 5 * kTick_ns) == STILLGRID_DEVICE_END);
    CHECK(replay.state.position_m[1] == 0.2);  // where it ended
    CHECK(replay.write(kStart_ns + 5 * kTick_ns, 1, 1, 1) == STILLGRID_DEVICE_OK);
    REQUIRE(replay.api.deactivate(replay.device) == STILLGRID_DEVICE_OK);
  }
}

TEST_CASE("A looping recording starts over and has no end", "[plugins]") {
  const RecordingFile file("t_s,x_m,y_m,z_m\n0,0,0,1\n0.002,0.2,0,1\n0.004,0,0,1\n");  // a round
  Plugin replay("replay");
  REQUIRE(replay.configure("file", file.path()) == STILLGRID_DEVICE_OK);
  REQUIRE(replay.configure("loop", "1") == STILLGRID_DEVICE_OK);
  REQUIRE(replay.api.activate(replay.device) == STILLGRID_DEVICE_OK);
  for (std::uint64_t n = 0; n < 20; ++n) REQUIRE(replay.read(n * kTick_ns) == STILLGRID_DEVICE_OK);
  REQUIRE(replay.read(41 * kTick_ns) == STILLGRID_DEVICE_OK);
  CHECK(replay.state.position_m[0] == Approx(0.1));
}

TEST_CASE("Between its end and its start a loop goes as a hand would, and turns so too",
          "[plugins]") {
  const RecordingFile file(
      "t_s,x_m,y_m,z_m,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n1,0.04,0.03,0,0,0,0.6,0.8\n");
  Plugin replay("replay");
  REQUIRE(replay.configure("file", file.path()) == STILLGRID_DEVICE_OK);
  REQUIRE(replay.configure("loop", "1") == STILLGRID_DEVICE_OK);
  REQUIRE(replay.api.activate(replay.device) == STILLGRID_DEVICE_OK);
  // The turn of 1.287 rad takes longest: 1.5 * 1.287 / 2 = 0.965 s.
  Eigen::Vector3d last_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond last_turn = Eigen::Quaterniond::Identity();
  double fastest_m_s = 0.0;
  double fastest_rad_s = 0.0;
  double slowest_start_m_s = 1.0;
  for (std::uint64_t n = 0; n < 4000; ++n) {
    REQUIRE(replay.read(n * kTick_ns) == STILLGRID_DEVICE_OK);
    const Eigen::Vector3d position_m = Eigen::Map<Eigen::Vector3d>(replay.state.position_m);
    const Eigen::Quaterniond turn(Eigen::Map<Eigen::Vector4d>(replay.state.orientation_xyzw));
    CHECK(turn.norm() == Approx(1.0).epsilon(1e-12));
    if (n > 1000 && n <= 1965) {
      fastest_m_s = std::max(fastest_m_s, (position_m - last_m).norm() * 1e3);
      fastest_rad_s = std::max(fastest_rad_s, turn.angularDistance(last_turn) * 1e3);
    }
    if (n == 1001 || n == 1965) {
      slowest_start_m_s = std::min(slowest_start_m_s, (position_m - last_m).norm() * 1e3);
    }
    last_m = position_m;
    last_turn = turn;
  }
  CHECK(fastest_rad_s == Approx(2.0).epsilon(1e-3));
  CHECK(fastest_m_s < 0.2);
  CHECK(slowest_start_m_s < 1e-3);

  REQUIRE(replay.read(1966 * kTick_ns) == STILLGRID_DEVICE_OK);  // a fresh round, 0.66 ms in
  CHECK(replay.state.position_m[0] < 1e-4);
}

}  // namespace
}  // namespace stillgrid::devices::replay_test
