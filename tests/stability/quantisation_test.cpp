// Encoder steps and Coulomb friction: cases 1.9 and 1.10 of docs/cases.md, whose figures are
// marked so.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "haptic_server/safety/energy_observer.hpp"
#include "tests/stability/held_loop.hpp"

namespace stillgrid::laboratory::quantisation_test {
namespace {

constexpr double kTick_s = 1e-3;

struct RealDevice {
  double damping_N_s_per_m, friction_N, resolution_m;
};

HeldLoop loop_of(const RealDevice& real) {
  return {0.1, real.damping_N_s_per_m, kTick_s, 0, real.friction_N, real.resolution_m};
}

/// The energy that a wall of 1 N/m gives to who moves in by stroke_m in one tick and out in the
/// next, from where the next step of the encoders is as near as can be.
double given_J_per_N_per_m(const RealDevice& real, double stroke_m) {
  const proto::SceneHeader scene = wall(1.0);
  devices::PhantomModel device = make_device(loop_of(real));
  const double start_m = -0.5 * (1.0 - 1e-9) * real.resolution_m;
  safety::HandEnergy energy;
  double held_N = 0.0, before_m = start_m;
  for (const double now_m : {start_m, start_m - stroke_m, start_m}) {
    const Eigen::Vector3d moved_m(0.0, 0.0, now_m - std::exchange(before_m, now_m));
    safety::observe(energy, {.force_N = {0.0, 0.0, held_N}},
                    {.moved_m = moved_m});  // of the true motion
    device.position_m.z() = now_m;
    held_N = force_N(scene, devices::read_encoders(device).z());
  }
  return energy.given_J;
}

/// What friction and damping take of the same stroke.
double taken_J(const RealDevice& real, double stroke_m) {
  return 2.0 * real.friction_N * stroke_m +
         2.0 * real.damping_N_s_per_m * stroke_m * stroke_m / kTick_s;
}

/// The greatest stiffness that gives no more than is taken, whatever the stroke.
double passive_limit_N_per_m(const RealDevice& real) {
  double limit_N_per_m = 1e9;
  for (double steps = 1.0; steps < 1e5; steps = std::ceil(1.01 * steps)) {
    // Just over a whole number of steps the encoders show one more.
    for (const double stroke_steps : {1e-5, steps - 0.5, steps, steps + 1e-6}) {
      const double stroke_m = stroke_steps * real.resolution_m;
      limit_N_per_m =
          std::min(limit_N_per_m, taken_J(real, stroke_m) / given_J_per_N_per_m(real, stroke_m));
    }
  }
  return limit_N_per_m;
}

TEST_CASE("Encoder steps leave a wall passive up to the lesser of 2 b/T and 2 f_c / Delta",
          "[quantisation]") {
  struct Row {
    RealDevice real;
    double published_N_per_m;
  };
  const auto [real, published_N_per_m] =
      GENERATE(Row{{5.0, 0.04, 30e-6}, 2666.7}, Row{{0.5, 0.04, 30e-6}, 1000.0},
               Row{{1.0, 0.01, 20e-6}, 1000.0});
  const double law_N_per_m =
      std::min(2.0 * real.damping_N_s_per_m / kTick_s, 2.0 * real.friction_N / real.resolution_m);
  CHECK(law_N_per_m == Approx(published_N_per_m).epsilon(1e-4));
  CHECK(passive_limit_N_per_m(real) == Approx(law_N_per_m).epsilon(5e-4));
}

TEST_CASE("Below that limit a device comes to a stop on the wall, by its own friction",
          "[quantisation]") {
  const RealDevice real = GENERATE(RealDevice{5.0, 0.04, 30e-6}, RealDevice{0.5, 0.04, 30e-6},
                                   RealDevice{1.0, 0.01, 20e-6});
  const double limit_N_per_m =
      std::min(2.0 * real.damping_N_s_per_m / kTick_s, 2.0 * real.friction_N / real.resolution_m);
  const proto::SceneHeader scene = wall(0.95 * limit_N_per_m);
  devices::PhantomModel device = make_pushed_device(loop_of(real), 1.0);
  for (int tick = 0; tick < 20'000; ++tick) {
    devices::command_force(device, {0.0, 0.0, force_N(scene, devices::read_encoders(device).z())});
    devices::advance_phantom(device, devices::kSubstepsPerTick);
  }
  CHECK(device.velocity_m_s.z() == 0.0);
}

struct FrictionCycle {
  double stiffness_N_per_m, mass_kg, damping_N_s_per_m, friction_N;
};

/// The amplitude at which the held spring gives what friction and damping take.
double cycle_amplitude_m(const FrictionCycle& c) {
  const double frequency_rad_s = std::sqrt(c.stiffness_N_per_m / c.mass_kg);
  return 4.0 * c.friction_N /
         (std::numbers::pi * frequency_rad_s *
          (0.5 * c.stiffness_N_per_m * kTick_s - c.damping_N_s_per_m));
}

/// Whether a device let go at start_m on a spring comes to rest, rather than to twice that.
bool dies(const FrictionCycle& c, double start_m) {
  const proto::SceneHeader scene = spring(c.stiffness_N_per_m);
  devices::PhantomModel device =
      make_device({c.mass_kg, c.damping_N_s_per_m, kTick_s, 0, c.friction_N});
  device.position_m.z() = start_m;
  for (int tick = 0; tick < 200'000; ++tick) {
    const double z_m = devices::read_encoders(device).z();
    if (std::abs(z_m) > 2.0 * start_m) return false;
    devices::command_force(device, {0.0, 0.0, force_N(scene, z_m)});
    devices::advance_phantom(device, devices::kSubstepsPerTick);
    if (device.velocity_m_s.z() == 0.0 &&
        std::abs(force_N(scene, device.position_m.z())) <= c.friction_N)
      return true;
  }
  FAIL("neither died nor grew");
  return false;
}

TEST_CASE("Friction stops a swing smaller than the limit cycle's, and loses to a larger one",
          "[quantisation]") {
  struct Row {
    FrictionCycle cycle;
    double law_m, published_m;
  };
  const auto [cycle, law_m, published_m] =
      GENERATE(Row{{1000.0, 0.1, 0.1, 0.04}, 1.2732e-3, 1.2758e-3},
               Row{{2000.0, 0.1, 0.1, 0.04}, 0.4001e-3, 0.4017e-3},
               Row{{500.0, 0.075, 0.005, 0.04}, 2.546e-3, 2.549e-3});
  const double amplitude_m = cycle_amplitude_m(cycle);
  CHECK(amplitude_m == Approx(law_m).epsilon(2e-4));
  CHECK(dies(cycle, 0.9 * amplitude_m));
  CHECK_FALSE(dies(cycle, 1.1 * amplitude_m));

  double least = 0.9, most = 1.1;
  while (most - least > 1e-5) {
    const double middle = 0.5 * (least + most);
    (dies(cycle, middle * amplitude_m) ? least : most) = middle;
  }
  CHECK(least * amplitude_m == Approx(published_m).epsilon(2e-4));
}

}  // namespace
}  // namespace stillgrid::laboratory::quantisation_test
