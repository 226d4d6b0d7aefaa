#include "haptic_server/devices/trajectory_faults.hpp"

#include <catch2/catch.hpp>
#include <random>
#include <string>

namespace stillgrid::devices::trajectory_faults_test {
namespace {

/// A hand at 1 kHz that wanders at no more than 0.5 m/s; its sensor reads every `stale` rows.
tables::Trajectory wandering(std::mt19937& random, std::size_t rows, std::size_t stale) {
  std::uniform_real_distribution<double> step_m(-2.5e-4, 2.5e-4);
  tables::Trajectory trajectory;
  Eigen::Vector3d hand_m = Eigen::Vector3d::Zero(), read_m = hand_m;
  for (std::size_t i = 0; i < rows; ++i) {
    hand_m += Eigen::Vector3d(step_m(random), step_m(random), step_m(random));
    if (i % stale == 0) read_m = hand_m;
    trajectory.time_s.push_back(1e-3 * static_cast<double>(i));
    trajectory.line.push_back(i + 2);
    trajectory.position_m.push_back(read_m);
  }
  return trajectory;
}

void cut(tables::Trajectory& trajectory, std::size_t row, double seconds) {
  for (std::size_t i = row; i < trajectory.time_s.size(); ++i) trajectory.time_s[i] += seconds;
}

TEST_CASE("A hand's own motion has no faults, however slow its sensor", "[trajectory_faults]") {
  std::mt19937 random(11);
  for (const std::size_t stale : {1U, 7U, 35U})
    for (int i = 0; i < 20; ++i)
      CHECK(faults_of("hand.csv", wandering(random, 500, stale)).empty());
}

TEST_CASE("A gap and a jump are told at their line wherever they are", "[trajectory_faults]") {
  std::mt19937 random(12);
  std::uniform_int_distribution<std::size_t> any_row(1, 499);
  for (int i = 0; i < 40; ++i) {
    const std::size_t row = any_row(random);
    const std::string line = "hand.csv:" + std::to_string(row + 2) + ": ";
    tables::Trajectory with_gap = wandering(random, 500, 1);
    cut(with_gap, row, 5.0);
    CHECK(faults_of("hand.csv", with_gap).starts_with(line + "gap of 5.001 s"));
    CHECK(faults_of("hand.csv", with_gap).find("1 gap and 0 jumps") != std::string::npos);
    tables::Trajectory with_jump = wandering(random, 500, 1);
    for (std::size_t k = row; k < 500; ++k) with_jump.position_m[k].x() += 1.0;
    CHECK(faults_of("hand.csv", with_jump).starts_with(line + "jump of "));
    CHECK(faults_of("hand.csv", with_jump).find("0 gaps and 1 jump,") != std::string::npos);
  }
}

TEST_CASE("A path of few rows, written by hand, is as it is meant", "[trajectory_faults]") {
  tables::Trajectory path;
  path.time_s = {0.0, 1e-3, 1000.0};
  path.line = {2, 3, 4};
  path.position_m = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones(), Eigen::Vector3d::Zero()};
  CHECK(faults_of("path.csv", path).empty());
}

}  // namespace
}  // namespace stillgrid::devices::trajectory_faults_test
