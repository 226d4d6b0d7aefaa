// The law of every limit: a contact gives the hand no more energy than the rendered force would
// have given, had it been told, or nothing where that would have taken some.

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "haptic_server/safety/safety_chain.hpp"
#include "tests/sanitizer_cut.hpp"

namespace stillgrid::safety::limits_make_no_energy_test {
namespace {

constexpr double kTick_s = 1e-3;
constexpr int kTicks = 4000;

/// A ball or, with an endless radius, the half-space below a plane; presses back along its normal.
struct Obstacle {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::UnitZ();
  double radius_m = std::numeric_limits<double>::infinity();
  double stiffness_N_per_m = 1000.0, damping_N_s_per_m = 0.0;
  double swing_m = 0.0, swing_hz = 0.0;  // along z: a body that moves
};

struct World {
  const char* name;
  std::vector<Obstacle> obstacles;
  double arm_m = 0.0;  // of the point that touches, along the tool's x
};

std::vector<World> worlds() {
  const Obstacle wall{};
  Obstacle soft = wall, stiff = wall, damped = wall, moves = wall;
  soft.stiffness_N_per_m = 300.0;
  stiff.stiffness_N_per_m = 4000.0;
  damped.damping_N_s_per_m = 3.0;
  moves.swing_m = 0.004;
  moves.swing_hz = 3.0;
  const auto ball = [](double x_m, double y_m) {
    return Obstacle{.centre_m = {x_m, y_m, -0.02}, .radius_m = 0.02, .stiffness_N_per_m = 600.0};
  };
  return {{"wall", {wall}},
          {"soft wall", {soft}},
          {"stiff wall", {stiff}},
          {"damped wall", {damped}},
          {"moving wall", {moves}},
          {"ball", {ball(0.0, 0.0)}},
          {"pocket", {ball(0.012, 0.0), ball(-0.008, 0.01), ball(-0.008, -0.01)}},
          {"rod at a wall", {wall}, 0.15},
          {"rod on balls", {ball(0.15, 0.0), ball(0.13, 0.015)}, 0.15}};
}

struct Hand {
  Eigen::Vector3d at_m = Eigen::Vector3d::Zero();
  double angle_rad = 0.0;  // about y
};

/// A smooth motion of three sines on each coordinate, drawn from a seed: slow strokes to taps.
class Motion {
 public:
  explicit Motion(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (auto& axis : waves_)
      for (auto& wave : axis)
        wave = {0.2 + 0.8 * unit(random), std::exp(std::log(0.5) + std::log(24.0) * unit(random)),
                2.0 * std::numbers::pi * unit(random)};
  }
  [[nodiscard]] Hand at(double time_s) const {
    std::array<double, 4> sum{};
    for (std::size_t axis = 0; axis < 4; ++axis)
      for (const auto& [size, hz, phase] : waves_[axis])
        sum[axis] +=
            size / (1.0 + 0.3 * hz) * std::sin(2.0 * std::numbers::pi * hz * time_s + phase);
    return {{0.006 * sum[0], 0.006 * sum[1], 0.006 * sum[2] + 0.001}, 0.05 * sum[3]};
  }

 private:
  struct Wave {
    double size, hz, phase;
  };
  std::array<std::array<Wave, 3>, 4> waves_{};
};

struct Rendered {
  Wrench wrench;
  double stored_J = 0.0, damping_N_s_per_m = 0.0;
  Eigen::Matrix3d stiffness_N_per_m = Eigen::Matrix3d::Zero();
};

Rendered render(const World& world, const Hand& hand, const Hand& before, double time_s) {
  const auto point_m = [&world](const Hand& h) -> Eigen::Vector3d {
    return h.at_m + Eigen::AngleAxisd(h.angle_rad, Eigen::Vector3d::UnitY()) *
                        Eigen::Vector3d(world.arm_m, 0.0, 0.0);
  };
  const Eigen::Vector3d at_m = point_m(hand), was_m = point_m(before);
  Rendered sum;
  for (const Obstacle& body : world.obstacles) {
    const double swing = body.swing_m * std::sin(2.0 * std::numbers::pi * body.swing_hz * time_s);
    const Eigen::Vector3d from_m = at_m - body.centre_m - Eigen::Vector3d(0.0, 0.0, swing);
    const bool is_ball = std::isfinite(body.radius_m);
    const Eigen::Vector3d normal = is_ball ? Eigen::Vector3d(from_m.normalized()) : body.normal;
    const double depth_m = is_ball ? body.radius_m - from_m.norm() : -from_m.dot(normal);
    if (depth_m <= 0.0) continue;
    const double inwards_m_s = std::max(0.0, -(at_m - was_m).dot(normal) / kTick_s);
    const Eigen::Vector3d force_N =
        (body.stiffness_N_per_m * depth_m + body.damping_N_s_per_m * inwards_m_s) * normal;
    sum.wrench.force_N += force_N;
    sum.wrench.torque_N_m += (at_m - hand.at_m).cross(force_N);
    sum.damping_N_s_per_m += body.damping_N_s_per_m;
    sum.stored_J += 0.5 * body.stiffness_N_per_m * depth_m * depth_m;
    sum.stiffness_N_per_m += body.stiffness_N_per_m * normal * normal.transpose();
  }
  return sum;
}

struct Stage {
  const char* name;
  SafetyLimits limits;
  bool loses_snapshot = false, loses_device = false;  // now and then
};

/// Each stage by itself, and all.
std::vector<Stage> stages() {
  constexpr double kEnough_N = 1e3;
  const SafetyLimits none{.max_force_N = kEnough_N, .lever_m = 1.0};
  std::vector<Stage> all = {
      {"norm", none},           {"torque", none},         {"slew", none},
      {"stiffness", none},      {"budget", none},         {"workspace", none},
      {"speed", none},          {"snapshot", none, true}, {"device", none, false, true},
      {"torque's budget", none}};
  all[0].limits.max_force_N = 2.0;
  all[1].limits.lever_m = 1e-4;
  all[2].limits.max_slew_N_per_ms = 0.15;
  all[3].limits.stiffness_N_per_m = 500.0;
  all[4].limits.continuous_force_N = 0.5;
  all[4].limits.motor_time_constant_s = 0.3;
  all[5].limits.workspace = {{-0.006, -0.006, -0.004}, {0.006, 0.006, 0.02}};
  all[6].limits.max_speed_m_s = 0.05;
  all[9].limits.continuous_torque_N_m = 1e-4;
  all[9].limits.motor_time_constant_s = 0.3;
  all.push_back({"all of a touch",
                 {.max_force_N = 3.3,
                  .max_slew_N_per_ms = 0.33,
                  .stiffness_N_per_m = 1020.0,
                  .continuous_force_N = 0.88,
                  .motor_time_constant_s = 0.5,
                  .max_speed_m_s = 0.3,
                  .workspace = {{-0.01, -0.01, -0.01}, {0.01, 0.01, 0.02}}},
                 true,
                 true});
  return all;
}

/// The greatest excess of a contact over its allowance, J, and how many contacts there were.
struct Excess {
  double most_J = -1.0;
  int contacts = 0;
  double limited_J = 0.0;  // that the limits took in all: they acted
};

Excess excess_of(const World& world, const Stage& stage, unsigned seed) {
  const Motion motion(seed);
  SafetyChain chain(stage.limits);
  Excess excess;
  Wrench commanded;
  Rendered before;
  double commanded_J = 0.0, rendered_J = 0.0, could_J = 0.0, rest_J = 0.0, tick_J = 0.0;
  Hand was = motion.at(0.0);
  for (int tick = 0; tick < kTicks; ++tick) {
    const double time_s = kTick_s * tick;
    const Hand hand = motion.at(time_s);
    const DeviceMotion moved{hand.at_m - was.at_m,
                             Eigen::Vector3d(0.0, hand.angle_rad - was.angle_rad, 0.0)};
    commanded_J += 0.5 * work_J(commanded, moved);
    rendered_J += 0.5 * work_J(before.wrench, moved);
    // The first and the last tick of a contact, in part without.
    const double arm_m = moved.moved_m.norm() + world.arm_m * moved.turned_rad.norm();
    const double secant_N_per_m =
        before.stiffness_N_per_m.trace() + before.damping_N_s_per_m / kTick_s;
    tick_J = std::max(tick_J, 0.5 * secant_N_per_m * arm_m * arm_m);
    const Rendered now = render(world, hand, was, time_s);
    if (now.wrench.force_N.isZero(0.0)) {
      if (!before.wrench.force_N.isZero(0.0)) {
        ++excess.contacts;
        excess.most_J = std::max(excess.most_J, commanded_J - could_J - rest_J - tick_J);
        excess.limited_J += std::abs(commanded_J - rendered_J);
      }
      commanded_J = rendered_J = could_J = rest_J = tick_J = 0.0;
    }
    rendered_J += 0.5 * work_J(now.wrench, moved);
    could_J = std::max(could_J, rendered_J + now.stored_J);
    SafetyInput input{.rendered = now.wrench,
                      .stiffness_N_per_m = now.stiffness_N_per_m,
                      .snapshot = {true, 0.0, 0.033, !stage.loses_snapshot || tick % 700 > 250},
                      .device_believed = !stage.loses_device || tick % 900 > 200,
                      .device_m = hand.at_m,
                      .velocity_m_s = moved.moved_m / kTick_s,
                      .motion = moved};
    // What comes back at rest, within a second.
    const Wrench& force = now.wrench;
    if (std::abs(work_J(force, moved)) < 0.02 * kTick_s * norm_N(force, stage.limits.lever_m))
      rest_J += kTick_s * 0.5 * now.wrench.force_N.squaredNorm() /
                std::max(1.0, now.stiffness_N_per_m.trace());
    std::uint32_t flags = 0;
    commanded = chain.apply(input, flags);
    commanded_J += 0.5 * work_J(commanded, moved);
    before = now;
    was = hand;
  }
  return excess;
}

TEST_CASE("No limit gives the hand energy that the rendered force would not have given",
          "[safety_chain]") {
  for (const Stage& stage : stages()) {
    int contacts = 0;
    double limited_J = 0.0;
    for (const World& world : worlds())
      for (unsigned seed = 1; seed < tests::seeds_end(9); ++seed) {
        const Excess excess = excess_of(world, stage, seed);
        contacts += excess.contacts;
        limited_J += excess.limited_J;
        INFO(stage.name << ", " << world.name << ", seed " << seed);
        CHECK(excess.most_J <= 1e-9);
      }
    INFO(stage.name);
    CHECK(contacts > 500 / tests::kCut);
    CHECK(limited_J > 1e-3 / tests::kCut);
  }
}

}  // namespace
}  // namespace stillgrid::safety::limits_make_no_energy_test
