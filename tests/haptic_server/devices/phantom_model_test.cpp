#include "haptic_server/devices/phantom_model.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

namespace stillgrid::devices::phantom_model_test {
namespace {

/// A bare mass and damper: no hand, friction, encoder or limit.
PhantomSettings bare_device(double mass_kg, double damping_N_s_per_m) {
  PhantomSettings settings;
  settings.device.mass_kg = mass_kg;
  settings.device.damping_N_s_per_m = damping_N_s_per_m;
  settings.path.kind = PathKind::kStill;
  settings.path.centre_m.setZero();
  return settings;
}

void tick(PhantomModel& model, const Eigen::Vector3d& force_N) {
  command_force(model, force_N);
  advance_phantom(model, kSubstepsPerTick);
}

/// The largest |x| over the last tenth of the ticks, against a bilateral spring.
double late_swing_m(PhantomModel model, double stiffness_N_per_m, int ticks) {
  double swing_m = 0.0;
  for (int n = 0; n < ticks; ++n) {
    const double x_m = read_encoders(model).x();
    if (n > ticks - ticks / 10) swing_m = std::max(swing_m, std::abs(x_m));
    tick(model, {-stiffness_N_per_m * x_m, 0.0, 0.0});
  }
  return swing_m;
}

/// The largest modulus of the eigenvalues of one tick under force -K x.
double spectral_radius(const PhantomSettings& settings, double stiffness_N_per_m) {
  Eigen::Matrix2d map;
  for (Eigen::Index column = 0; column < 2; ++column) {
    PhantomSettings unit = settings;
    (column == 0 ? unit.start_m : unit.start_velocity_m_s).x() = 1.0;
    PhantomModel model = make_phantom(unit);
    tick(model, {-stiffness_N_per_m * model.position_m.x(), 0.0, 0.0});
    map.col(column) << model.position_m.x(), model.velocity_m_s.x();
  }
  return map.eigenvalues().cwiseAbs().maxCoeff();
}

double largest_stable_stiffness_N_per_m(const PhantomSettings& settings) {
  double stable = 0.0;
  double unstable = 1e6;
  for (int n = 0; n < 60; ++n) {
    const double middle = 0.5 * (stable + unstable);
    (spectral_radius(settings, middle) < 1.0 ? stable : unstable) = middle;
  }
  return stable;
}

TEST_CASE("A held force moves a damped mass as the exact solution says", "[phantom_model]") {
  PhantomSettings settings = bare_device(0.1, 5.0);
  settings.start_m.x() = 0.02;
  settings.start_velocity_m_s.x() = -0.3;
  PhantomModel model = make_phantom(settings);
  for (int n = 0; n < 50; ++n) tick(model, {2.0, 0.0, 0.0});

  // m v' = F - b v, so v = F/b + (v0 - F/b) exp(-b t / m)
  const double time_s = 0.05;
  const double decay = std::exp(-5.0 * time_s / 0.1);
  const double final_m_s = 2.0 / 5.0;
  CHECK(model.velocity_m_s.x() == Approx(final_m_s + (-0.3 - final_m_s) * decay).epsilon(1e-11));
  CHECK(model.position_m.x() ==
        Approx(0.02 + final_m_s * time_s + (-0.3 - final_m_s) * 0.1 / 5.0 * (1.0 - decay))
            .epsilon(1e-11));
}

TEST_CASE("Held by a hand at rest it swings as the exact solution says", "[phantom_model]") {
  PhantomSettings settings = bare_device(0.045, 0.0);
  settings.hand = {0.055, 0.4, 300.0};
  settings.start_m.y() = 0.01;
  PhantomModel model = make_phantom(settings);
  for (int n = 0; n < 200; ++n) tick(model, Eigen::Vector3d::Zero());

  const double decay_1_s = 0.4 / (2.0 * 0.1);
  const double frequency_rad_s = std::sqrt(300.0 / 0.1 - decay_1_s * decay_1_s);
  const double angle = frequency_rad_s * 0.2;
  const double expected_m = 0.01 * std::exp(-decay_1_s * 0.2) *
                            (std::cos(angle) + decay_1_s / frequency_rad_s * std::sin(angle));
  CHECK(model.position_m.y() == Approx(expected_m).margin(1e-12));
}

TEST_CASE("A hand on a moving path is followed to second order", "[phantom_model]") {
  // The path of a press is a cosine, so the steady motion is known in closed form.
  PhantomSettings settings = bare_device(0.045, 0.1);
  settings.hand = *hand_profile("light");
  settings.path = Path{};
  settings.path.period_s = 0.5;
  settings.start_m = settings.path.centre_m;
  PhantomModel model = make_phantom(settings);
  for (int n = 0; n < 10'000; ++n) tick(model, Eigen::Vector3d::Zero());

  const double frequency_rad_s = 2.0 * std::numbers::pi / 0.5;
  const std::complex<double> i(0.0, 1.0);
  const std::complex<double> pull = 300.0 + i * frequency_rad_s * 2.0;
  const std::complex<double> gain =
      pull / (pull - 0.145 * frequency_rad_s * frequency_rad_s + i * frequency_rad_s * 0.1);
  const double steady_m =
      0.03 - 0.02 * (1.0 - std::real(gain * std::exp(i * frequency_rad_s * 10.0)));
  CHECK(model.position_m.z() == Approx(steady_m).margin(1e-8));
}

TEST_CASE("The largest stable stiffness is that of the exact zero-order hold", "[phantom_model]") {
  struct Row {
    double damping_N_s_per_m, tick_s, limit_N_per_m;
  };
  const auto row =
      GENERATE(Row{1.0, 1e-3, 2003.34}, Row{5.0, 1e-3, 10084.03}, Row{5.0, 1e-2, 1090.50},
               Row{5.0, 0.1 / 3.0, 408.56}, Row{5.0, 0.1, 165.19});
  PhantomSettings settings = bare_device(0.1, row.damping_N_s_per_m);
  settings.tick_s = row.tick_s;
  CHECK(largest_stable_stiffness_N_per_m(settings) == Approx(row.limit_N_per_m).epsilon(2e-5));
}

TEST_CASE("In the measured hand the limit is the published one", "[phantom_model]") {
  struct Row {
    double tick_s, limit_N_per_m;
  };
  const auto row =
      GENERATE(Row{1e-3, 14928.6}, Row{1e-2, 1521.5}, Row{0.1 / 3.0, 486.6}, Row{0.1, 220.8});
  PhantomSettings settings = bare_device(0.1, 1.0);
  settings.hand = *hand_profile("measured");
  settings.tick_s = row.tick_s;
  CHECK(largest_stable_stiffness_N_per_m(settings) == Approx(row.limit_N_per_m).epsilon(3e-4));
}

TEST_CASE("A delay of whole ticks lowers the limit as K (T/2 + td) < b predicts",
          "[phantom_model]") {
  struct Row {
    int delay_ticks;
    double limit_N_per_m;
  };
  const auto row = GENERATE(Row{1, 668.5}, Row{3, 287.4}, Row{10, 96.9}, Row{33, 31.40});
  PhantomSettings settings = bare_device(0.1, 1.0);
  settings.start_m.x() = 1e-3;
  settings.delay_ticks = row.delay_ticks;
  CHECK(late_swing_m(make_phantom(settings), 0.97 * row.limit_N_per_m, 20'000) < 1e-3);
  CHECK(late_swing_m(make_phantom(settings), 1.03 * row.limit_N_per_m, 20'000) > 1e-3);
}

TEST_CASE("A command acts after exactly the delay, and for one tick each", "[phantom_model]") {
  const int delay_ticks = GENERATE(0, 1, 5, kMaxDelayTicks);
  PhantomSettings settings = bare_device(0.1, 0.0);
  settings.delay_ticks = delay_ticks;
  PhantomModel model = make_phantom(settings);
  for (int n = 0; n < delay_ticks + 10; ++n) {
    command_force(model, {1.0 + n, 0.0, 0.0});
    CHECK(model.held_force_N.x() == (n < delay_ticks ? 0.0 : 1.0 + n - delay_ticks));
  }
  release_force(model);
  command_force(model, Eigen::Vector3d::Zero());
  CHECK(model.held_force_N.isZero());
}

TEST_CASE("Friction holds the tip exactly still against a smaller push", "[phantom_model]") {
  PhantomSettings settings = bare_device(0.1, 1.0);
  settings.device.friction_N = 0.26;
  settings.start_m = {0.01, 0.02, 0.03};
  settings.push_N = {0.15, -0.15, 0.15};  // norm 0.2598
  PhantomModel model = make_phantom(settings);
  for (int n = 0; n < 1000; ++n) tick(model, Eigen::Vector3d::Zero());
  CHECK(model.position_m == settings.start_m);
  CHECK(model.velocity_m_s.isZero(0.0));

  tick(model, {0.001, -0.001, 0.001});  // norm 0.2615: friction is of the vector
  CHECK(model.velocity_m_s.norm() > 0.0);
}

TEST_CASE("Friction brings a sliding tip to rest in its time, and to rest exactly",
          "[phantom_model]") {
  PhantomSettings settings = bare_device(0.1, 0.0);
  settings.device.friction_N = 0.2;
  settings.start_velocity_m_s = {0.06, 0.08, 0.0};  // stops after m v / f = 50 ms
  PhantomModel model = make_phantom(settings);
  for (int n = 0; n < 49; ++n) tick(model, Eigen::Vector3d::Zero());
  CHECK(model.velocity_m_s.norm() == Approx(0.002));
  CHECK(model.velocity_m_s.y() / model.velocity_m_s.x() == Approx(0.08 / 0.06));
  for (int n = 0; n < 3; ++n) tick(model, Eigen::Vector3d::Zero());
  CHECK(model.velocity_m_s.isZero(0.0));
  CHECK(model.position_m.norm() == Approx(0.1 * 0.1 / (2.0 * 2.0)).epsilon(1e-3));
}

TEST_CASE("Friction and a held spring: small swings die, large ones grow", "[phantom_model]") {
  // The unstable limit cycle A = 4 f / (pi w (K T / 2 - b)), for K > 2 b / T.
  PhantomSettings settings = bare_device(0.1, 0.1);
  settings.device.friction_N = 0.04;
  const double amplitude_m = 1.2758e-3;  // at K = 1000 N/m
  settings.start_m.x() = 0.9 * amplitude_m;
  CHECK(late_swing_m(make_phantom(settings), 1000.0, 5'000) < 0.5 * amplitude_m);
  settings.start_m.x() = 1.1 * amplitude_m;
  CHECK(late_swing_m(make_phantom(settings), 1000.0, 5'000) > 1.5 * amplitude_m);
}

TEST_CASE("The amplifier cuts the norm of a force and keeps its direction", "[phantom_model]") {
  PhantomSettings settings = bare_device(0.1, 0.0);
  settings.device.max_force_N = 3.3;
  PhantomModel model = make_phantom(settings);
  command_force(model, {30.0, 0.0, -40.0});
  CHECK((model.held_force_N - Eigen::Vector3d(1.98, 0.0, -2.64)).norm() < 1e-12);
  command_force(model, {3.0, 0.0, 0.0});
  CHECK(model.held_force_N.x() == 3.0);
  command_force(model, {1e300, 1e300, 0.0});
  CHECK(model.held_force_N.norm() == Approx(3.3));

  const double nan = std::numeric_limits<double>::quiet_NaN();
  command_force(model, {nan, 1.0, 0.0});
  CHECK(model.held_force_N.isZero(0.0));
}

TEST_CASE("Encoders show the nearest of their steps", "[phantom_model]") {
  PhantomSettings settings = bare_device(0.1, 0.0);
  settings.device.resolution_m = 1e-4;
  settings.start_m = {1.26e-4, -1.6e-4, 0.4e-4};
  PhantomModel model = make_phantom(settings);
  CHECK((read_encoders(model) - Eigen::Vector3d(1e-4, -2e-4, 0.0)).norm() < 1e-15);
}

TEST_CASE("Noise stays within its bound and follows the seed", "[phantom_model]") {
  PhantomSettings settings = bare_device(0.1, 0.0);
  settings.noise_m = 1e-4;
  PhantomModel one = make_phantom(settings);
  PhantomModel same = make_phantom(settings);
  settings.seed = 2;
  PhantomModel other = make_phantom(settings);
  double largest_m = 0.0;
  for (int n = 0; n < 1000; ++n) {
    const Eigen::Vector3d read_m = read_encoders(one);
    CHECK(read_m == read_encoders(same));
    CHECK(read_m != read_encoders(other));
    largest_m = std::max(largest_m, read_m.cwiseAbs().maxCoeff());
  }
  CHECK(largest_m <= 1e-4);
  CHECK(largest_m > 0.99e-4);
}

TEST_CASE("Profiles and hands are found by name", "[phantom_model]") {
  CHECK(phantom_profile("touch")->max_force_N == 3.3);
  CHECK(phantom_profile("touchx")->resolution_m == 0.023e-3);
  CHECK(phantom_profile("premium15")->nominal_stiffness_N_per_m == 3500.0);
  CHECK_FALSE(phantom_profile("omega"));
  CHECK(hand_profile("none")->mass_kg == 0.0);
  CHECK(hand_profile("measured")->stiffness_N_per_m == 135.0);
  CHECK_FALSE(hand_profile("heavy"));
}

}  // namespace
}  // namespace stillgrid::devices::phantom_model_test
