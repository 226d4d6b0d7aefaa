#include "haptic_server/safety/interface_account.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "haptic_server/safety/passivity_controller.hpp"

namespace stillgrid::safety::interface_account_test {
namespace {

constexpr std::uint64_t kMillisecond_ns = 1'000'000;

DeviceMotion up(double z_m) {
  return {.moved_m = {0.0, 0.0, z_m}};
}

/// A scene that moves: its snapshot, and the force and stiffness rendered from it.
RenderedScene seen(std::uint64_t snapshot_id, std::uint64_t tool_time_ns, double tool_work_J,
                   double z_N = 0.0, double stiffness_N_per_m = 0.0) {
  return {.epoch = 7,
          .snapshot_id = snapshot_id,
          .can_move = true,
          .tool_time_ns = tool_time_ns,
          .tool_work_J = tool_work_J,
          .rendered = {{0.0, 0.0, z_N}, Eigen::Vector3d::Zero()},
          .stiffness_N_per_m = stiffness_N_per_m};
}

/// What is shown from a tick on.
struct Arrival {
  std::size_t tick, sample;
};

/// Of a tick: its time, what the hand gave up to it, what the interface made up to it, in truth.
struct Truth {
  std::uint64_t time_ns;
  double given_J, made_J, stored_J;
};

/// A hand that wanders under a force that wanders, and an interface that makes energy at random.
class Wandering {
 public:
  Wandering(unsigned seed, double tick_jitter) : random_(seed), tick_jitter_(tick_jitter) {}

  /// Moves on by a tick; returns the motion.
  DeviceMotion move() {
    const double z_m = 1e-4 * normal_(random_), turn_rad = 1e-3 * normal_(random_);
    const double given_J = ticks.empty() ? 0.0 : ticks.back().given_J;
    const double made_J = ticks.empty() ? 0.0 : ticks.back().made_J;
    time_ns_ += static_cast<std::uint64_t>(1e6 * (1.0 + tick_jitter_ * uniform_(random_)));
    const double work_J = -force_N_ * z_m - torque_N_m_ * turn_rad;
    force_N_ = 0.99 * force_N_ + 0.3 * normal_(random_);
    torque_N_m_ = 0.01 * normal_(random_);
    ticks.push_back({time_ns_, given_J + work_J, made_J + 1e-5 * normal_(random_) + 1e-6,
                     0.5 * force_N_ * force_N_ / kStiffness_N_per_m});
    return {.moved_m = {0.0, 0.0, z_m}, .turned_rad = {turn_rad, 0.0, 0.0}};
  }
  RenderedScene shown(std::uint64_t snapshot_id, std::size_t sample, double before_J) {
    RenderedScene scene =
        seen(snapshot_id, ticks[sample].time_ns,
             before_J + ticks[sample].given_J + ticks[sample].made_J, force_N_, kStiffness_N_per_m);
    scene.rendered.torque_N_m.x() = torque_N_m_;
    return scene;
  }
  std::size_t up_to(std::size_t most) {
    return std::uniform_int_distribution<std::size_t>(0, most)(random_);
  }

  static constexpr double kStiffness_N_per_m = 873.0;
  std::vector<Truth> ticks;

 private:
  std::mt19937_64 random_;
  double tick_jitter_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
  std::uint64_t time_ns_ = 3'000'000'000;
  double force_N_ = 0.0, torque_N_m_ = 0.0;
};

/// The most made in any second or longer between samples, looked for among all pairs.
std::optional<double> most_made_J(const std::vector<Truth>& ticks,
                                  const std::vector<std::size_t>& joined) {
  std::optional<double> most_J;
  for (const std::size_t end : joined)
    for (const std::size_t start : joined) {
      if (ticks[start].time_ns + 1000 * kMillisecond_ns > ticks[end].time_ns) continue;
      const double made_J = ticks[end].made_J - ticks[start].made_J;
      most_J = std::max(most_J.value_or(made_J), made_J);
    }
  return most_J;
}

struct Lateness {
  double tick_jitter;
  std::size_t period, least, spread;  // ticks: of snapshots, of a sample's age and its spread
  double lost;                        // share of snapshots that no tick shows
};

TEST_CASE("What was made is told whatever the snapshots' age, jitter and losses",
          "[interface_account]") {
  const Lateness late = GENERATE(Lateness{0.0, 33, 0, 0, 0.0}, Lateness{0.0, 1, 0, 0, 0.0},
                                 Lateness{0.3, 33, 5, 61, 0.0}, Lateness{0.3, 97, 97, 190, 0.4},
                                 Lateness{0.1, 700, 200, 900, 0.3});
  for (unsigned seed = 1; seed <= 6; ++seed) {
    INFO("seed " << seed << ", period " << late.period);
    Wandering world(seed, late.tick_jitter);
    InterfaceAccount account(1e-3);
    std::uint64_t snapshot_id = 1;
    std::size_t sample = 0;
    std::vector<std::size_t> joined{0};
    constexpr double kBefore_J = -3.7;  // booked before this loop came
    for (std::size_t tick = 0; tick < 9'731; ++tick) {
      const DeviceMotion motion = world.move();
      if (tick > 0 && tick % late.period == 0) {
        ++snapshot_id;
        const std::size_t age = late.least + world.up_to(late.spread);
        const bool is_lost = static_cast<double>(world.up_to(999)) < 1e3 * late.lost;
        if (!is_lost && tick > age && tick - age >= sample) {
          sample = tick - age;
          joined.push_back(sample);
        }
      }
      const double offset_J = kBefore_J - world.ticks[0].given_J - world.ticks[0].made_J;
      account.note(world.ticks[tick].time_ns, motion, world.shown(joined.size(), sample, offset_J));
    }
    const std::vector<Truth>& ticks = world.ticks;
    const auto energy = account.energy();
    REQUIRE(energy);
    REQUIRE(joined.size() > 4);
    CHECK(energy->given_by_hand_J == Approx(ticks.back().given_J).margin(1e-12));
    CHECK(energy->made_J == Approx(ticks[sample].made_J - ticks[0].made_J).margin(1e-12));
    CHECK(energy->booked_J ==
          Approx(ticks[sample].given_J + ticks[sample].made_J - ticks[0].made_J).margin(1e-12));
    CHECK(energy->in_flight_J ==
          Approx(ticks.back().given_J - ticks[sample].given_J).margin(1e-12));
    CHECK(energy->uncertainty_J == Approx(std::abs(energy->in_flight_J) +
                                          std::max(ticks[sample].stored_J, ticks.back().stored_J))
                                       .margin(1e-12));
    const auto most_J = most_made_J(ticks, joined);
    REQUIRE(most_J.has_value() == energy->most_made_in_a_second_J.has_value());
    CHECK(*energy->most_made_in_a_second_J == Approx(*most_J).margin(1e-12));
  }
}

TEST_CASE("What was made is remembered over a gap that is longer than the ticks are",
          "[interface_account]") {
  InterfaceAccount account(1e-3);
  std::uint64_t now_ns = 5 * kMillisecond_ns;
  const auto tick = [&](std::uint64_t id, std::uint64_t sample_ns, double booked_J) {
    account.note(now_ns, {}, seen(id, sample_ns, booked_J));
    now_ns += kMillisecond_ns;
  };
  tick(1, now_ns, 0.0);
  tick(2, now_ns, -0.25);
  const std::uint64_t early_ns = now_ns;
  for (int i = 0; i < 6'500; ++i) tick(2, early_ns, -0.25);
  CHECK_FALSE(account.energy()->most_made_in_a_second_J);
  tick(3, early_ns, -0.1);  // of a tick that is forgotten: not joined, and no harm
  CHECK(account.energy()->made_J == -0.25);
  tick(4, now_ns, 0.5);
  CHECK(account.energy()->most_made_in_a_second_J == Approx(0.75));
}

TEST_CASE("A snapshot that cannot be true ends the account of its scene", "[interface_account]") {
  InterfaceAccount account(1e-3);
  for (std::uint64_t i = 1; i <= 50; ++i)
    account.note(10 * i * kMillisecond_ns, up(-1e-4),
                 seen(1 + i / 10, i < 10 ? 0 : 100 * (i / 10) * kMillisecond_ns, 1e-3, 2.0));
  REQUIRE(account.energy());
  const double infinite = std::numeric_limits<double>::infinity();
  const auto [time_ns, work_J] = GENERATE(table<std::uint64_t, double>(
      {{500 * kMillisecond_ns, std::numeric_limits<double>::quiet_NaN()},
       {0, std::numeric_limits<double>::infinity()},
       {500 * kMillisecond_ns, -std::numeric_limits<double>::infinity()},
       {500 * kMillisecond_ns, 1.1e6},
       {520 * kMillisecond_ns, 0.0},  // yet to come
       {UINT64_MAX, 0.0},
       {495 * kMillisecond_ns, 0.0},     // no tick's
       {300 * kMillisecond_ns, 0.0}}));  // before one that was joined
  account.note(510 * kMillisecond_ns, up(1e-4), seen(99, time_ns, work_J, infinite));
  CHECK_FALSE(account.energy());
  CHECK(account.given_by_scenes_J() == 0.0);
  account.note(520 * kMillisecond_ns, up(1e-4), seen(100, 510 * kMillisecond_ns, 0.0));
  CHECK_FALSE(account.energy());
  RenderedScene other = seen(1, 0, 55.0);
  other.epoch = 8;
  account.note(530 * kMillisecond_ns, up(1e-4), other);
  CHECK_FALSE(account.energy());  // not yet
  other.snapshot_id = 2;
  other.tool_time_ns = 530 * kMillisecond_ns;
  other.tool_work_J = 55.5;
  account.note(540 * kMillisecond_ns, up(1e-4), other);
  REQUIRE(account.energy());
  CHECK(account.energy()->made_J == Approx(0.5));
}

TEST_CASE("A tool that the simulation loses for a while leaves the account as it was",
          "[interface_account]") {
  InterfaceAccount account(1e-3);
  for (std::uint64_t tick = 0; tick < 9; ++tick)  // virtual time begins at zero
    account.note(
        tick * kMillisecond_ns, {},
        seen(1 + tick, tick < 3 || tick == 8 ? tick * kMillisecond_ns : 0, tick < 8 ? 0.2 : 0.5));
  REQUIRE(account.energy());
  CHECK(account.energy()->made_J == Approx(0.3));
}

TEST_CASE("A force that is no number is no work", "[interface_account]") {
  InterfaceAccount account(1e-3);
  const double none = std::numeric_limits<double>::quiet_NaN();
  account.note(1 * kMillisecond_ns, {}, seen(1, 1 * kMillisecond_ns, 0.0, 1.0));
  account.note(2 * kMillisecond_ns, up(-1e-3), seen(1, 1 * kMillisecond_ns, 0.0, none, none));
  account.note(3 * kMillisecond_ns, up(-1e-3), seen(2, 3 * kMillisecond_ns, 0.0, 1.0));
  REQUIRE(account.energy());
  CHECK(account.energy()->given_by_hand_J == Approx(1e-3));
}

TEST_CASE("Over a wall what is made is the leak of the hold at every tick", "[interface_account]") {
  // Case 1.6: K/2 sum dx^2.
  constexpr double kStiffness_N_per_m = 1170.0;
  const bool can_move = GENERATE(false, true);  // something else, far away
  InterfaceAccount account(1e-3);
  double before_m = 0.0, squares_m2 = 0.0;
  for (std::uint64_t tick = 1; tick <= 731; ++tick) {
    const double depth_m = 0.004 * std::max(0.0, std::sin(0.0123 * static_cast<double>(tick)));
    squares_m2 += (depth_m - before_m) * (depth_m - before_m);
    RenderedScene scene =
        seen(tick, tick * kMillisecond_ns, 0.0, kStiffness_N_per_m * depth_m, kStiffness_N_per_m);
    scene.static_J = 0.5 * kStiffness_N_per_m * depth_m * depth_m;
    scene.can_move = can_move;
    if (!can_move) scene.tool_time_ns = 0;
    account.note(tick * kMillisecond_ns, up(before_m - depth_m), scene);
    before_m = depth_m;
    REQUIRE(account.energy());
    REQUIRE(account.energy()->made_J ==
            Approx(0.5 * kStiffness_N_per_m * squares_m2).margin(1e-12));
    REQUIRE(account.energy()->held_J == scene.static_J);
    REQUIRE(account.energy()->uncertainty_J < 1e-15);
  }
}

TEST_CASE("What white noise of the positions made is told, and the leak of the hold is not",
          "[interface_account]") {
  // A spring with a damper on the measured speed of the last two ticks, pressed for a minute; in
  // truth what is made is the force over the way that the hand went.
  const double noise_m = GENERATE(0.0, 1e-5, 4e-5);
  for (unsigned seed = 1; seed <= 8; ++seed) {
    constexpr double kStiffness_N_per_m = 1170.0, kDamping_N_s_per_m = 0.7;
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> noise(-noise_m, noise_m);
    InterfaceAccount account(1e-3);
    double way_m = 0.0, shown_m = 0.0, before_m = 0.0, force_N = 0.0, given_J = 0.0;
    constexpr std::uint64_t kTicks = 60'000;
    for (std::uint64_t tick = 1; tick <= kTicks; ++tick) {
      const double next_m = 0.004 + 0.003 * std::sin(0.0123 * static_cast<double>(tick));
      given_J += force_N * (next_m - way_m);
      const double measured_m = next_m + noise(random);
      const DeviceMotion motion = up(shown_m - measured_m);
      const double speed_m_s = (measured_m - before_m) / 2e-3;
      way_m = next_m;
      before_m = std::exchange(shown_m, measured_m);
      force_N = tick < 3 ? 0.0 : kStiffness_N_per_m * shown_m + kDamping_N_s_per_m * speed_m_s;
      account.note(tick * kMillisecond_ns, motion,
                   seen(tick, tick * kMillisecond_ns, 0.0, force_N));
    }
    REQUIRE(account.energy());
    const double truly_J = -given_J, of_noise_J = account.energy()->made_J - truly_J;
    INFO("seed " << seed << ", noise " << noise_m << " m, made in truth " << truly_J << " J");
    const double response_N_per_m = kStiffness_N_per_m + kDamping_N_s_per_m / 2e-3;
    const double expected_J = kTicks * response_N_per_m * noise_m * noise_m / 3.0;
    CHECK(account.energy()->noise_J == Approx(expected_J).epsilon(0.1).margin(1e-5));
    CHECK(of_noise_J == Approx(expected_J).epsilon(0.1).margin(1e-5));
  }
}

TEST_CASE("Control takes back what the hand was given, but for what a body gave",
          "[interface_account]") {
  PassivityController controller(0.1);
  std::uint32_t flags = 0;
  HandEnergy account{.given_J = 1.0};
  CHECK(controller.damp(account, 1.1, up(1e-4), 1e-3, flags).isZero(0.0));
  CHECK(flags == 0);
  CHECK(controller.damp(account, 1.0 - 1e-6, up(1e-4), 1e-3, flags).z() == Approx(-1e-6 / 1e-4));
  CHECK(flags == kFlagPassivity);
}

TEST_CASE("What scenes gave is what the tool took of them, in the device's scale",
          "[interface_account]") {
  InterfaceAccount account(1e-3);
  CHECK(account.given_by_scenes_J() == 0.0);
  auto show = [&, now_ns = kMillisecond_ns](RenderedScene scene) mutable {
    scene.tool_time_ns = now_ns;
    account.note(now_ns, {}, scene);
    now_ns += kMillisecond_ns;
  };
  RenderedScene scene = seen(1, 0, 2.0);
  scene.scale = 4.0;
  show(scene);
  ++scene.snapshot_id;
  scene.tool_work_J = 2.5;  // the tool gave
  show(scene);
  CHECK(account.given_by_scenes_J() == 0.0);
  ++scene.snapshot_id;
  scene.tool_work_J = 1.2;
  show(scene);
  CHECK(account.given_by_scenes_J() == Approx(0.2));
  // The springs that are pressed may be given back, too.
  scene.rendered.force_N = {0.0, 3.0, 0.0};
  scene.stiffness_N_per_m = 90.0;
  show(scene);
  CHECK(account.given_by_scenes_J() == Approx((0.8 + 0.05) / 4.0));
  RenderedScene other = seen(1, 0, -7.0);
  other.epoch = 8;
  show(other);
  CHECK(account.given_by_scenes_J() == Approx(0.85 / 4.0));
  ++other.snapshot_id;
  other.tool_work_J = -7.1;
  show(other);
  CHECK(account.given_by_scenes_J() == Approx(0.85 / 4.0 + 0.1));
  ++other.snapshot_id;
  other.tool_work_J = std::numeric_limits<double>::quiet_NaN();
  show(other);
  CHECK(account.given_by_scenes_J() == Approx(0.85 / 4.0));
}

}  // namespace
}  // namespace stillgrid::safety::interface_account_test
