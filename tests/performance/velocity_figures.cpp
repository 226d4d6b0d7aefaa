// Estimators of velocity against each other: prints docs/charts/velocity.csv, of which --small only
// what the chart shows, from two motions of four. Needs the folder of real inputs.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "haptic_server/devices/phantom_model.hpp"
#include "haptic_server/devices/trajectory.hpp"
#include "haptic_server/devices/trajectory_curve.hpp"
#include "shared/collision/contact_law.hpp"
#include "tests/haptic_server/devices/recording_file.hpp"
#include "tests/performance/velocity_rivals.hpp"

namespace stillgrid::performance {
namespace {

constexpr double kStep_m = 30e-6;  // of the encoders
constexpr double kTick_s = 1e-3;

/// A recorded motion with all that is faster than a hand taken off, so that its velocity is known.
struct Motion {
  std::string name;
  int axes;
  devices::TrajectoryCurve curve;
  double end_s;
};

/// Where and when a tick reads the device; a stale reading repeats the position before.
struct Reading {
  double time_s;
  bool is_stale;
};

Motion smooth(const std::string& name, int axes, const devices::Trajectory& recorded,
              double knot_spacing_s) {
  constexpr int kKernelHalfWidth = 24;  // four standard deviations of 6 ms
  const devices::TrajectoryCurve rough =
      devices::make_curve(recorded, devices::Resampling::kCubic, knot_spacing_s);
  const int count = static_cast<int>(recorded.time_s.back() / kTick_s);
  devices::Trajectory motion;
  for (int i = kKernelHalfWidth; i < count - kKernelHalfWidth; ++i) {
    Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
    double weights = 0.0;
    devices::CurveCursor cursor;
    for (int k = -kKernelHalfWidth; k <= kKernelHalfWidth; ++k) {
      const double weight = std::exp(-k * k / 72.0);
      sum_m += weight * devices::curve_at(rough, kTick_s * (i + k), cursor).position_m;
      weights += weight;
    }
    motion.time_s.push_back(kTick_s * (i - kKernelHalfWidth));
    motion.position_m.emplace_back(sum_m / weights);
  }
  return {name, axes, devices::make_curve(motion, devices::Resampling::kCubic),
          motion.time_s.back()};
}

std::vector<Reading> even_readings(double end_s) {
  std::vector<Reading> readings;
  for (int i = 0; i * kTick_s < end_s; ++i) readings.push_back({i * kTick_s, false});
  return readings;
}

/// As the robot's logger did: its stamps, over and over, and the rows that it repeated.
std::vector<Reading> recorded_readings(const devices::Trajectory& logged, double end_s) {
  std::vector<Reading> readings;
  double start_s = 0.0;
  for (std::size_t i = 0; start_s + logged.time_s[i] < end_s;) {
    readings.push_back(
        {start_s + logged.time_s[i], i > 0 && logged.position_m[i] == logged.position_m[i - 1]});
    if (++i < logged.time_s.size()) continue;
    start_s += logged.time_s.back() + kTick_s;
    i = 0;
  }
  return readings;
}

/// Ticks that wake up to 0.1 ms late and miss 4 to 38 ms about twice a second.
std::vector<Reading> stalled_readings(double end_s) {
  std::mt19937 random(5);
  const auto share = [&] { return static_cast<double>(random() % 1000) / 1000.0; };
  std::vector<Reading> readings;
  for (int tick = 0; tick * kTick_s < end_s; ++tick) {
    readings.push_back({tick * kTick_s + 1e-4 * share(), false});
    if (share() < 0.002) tick += 4 + static_cast<int>(34.0 * share());
  }
  return readings;
}

std::vector<Eigen::Vector3d> estimates(const VelocityCandidate& candidate, const Motion& motion,
                                       const std::vector<Reading>& readings) {
  const VelocityUpdate update = candidate.start(kStep_m);
  std::vector<Eigen::Vector3d> found_m_s;
  Eigen::Vector3d rounded_m = Eigen::Vector3d::Zero();
  devices::CurveCursor cursor;
  for (const auto& [time_s, is_stale] : readings) {
    const Eigen::Vector3d exact_m = devices::curve_at(motion.curve, time_s, cursor).position_m;
    if (!is_stale) rounded_m = kStep_m * (exact_m / kStep_m).array().round();
    found_m_s.push_back(update(static_cast<std::uint64_t>(1e9 * time_s), rounded_m));
  }
  return found_m_s;
}

/// Root mean square per axis of what is left when the true velocity is shown lag_s late.
double noise_m_s(const Motion& motion, const std::vector<Reading>& readings,
                 const std::vector<Eigen::Vector3d>& found_m_s, double lag_s) {
  constexpr std::size_t kSettled = 100;
  double squares = 0.0;
  devices::CurveCursor cursor;
  for (std::size_t i = kSettled; i < readings.size(); ++i) {
    const double seen_s = readings[i].time_s - lag_s;
    const Eigen::Vector3d off_m_s =
        devices::curve_at(motion.curve, seen_s, cursor).velocity_m_s - found_m_s[i];
    squares += off_m_s.squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(motion.axes) /
                   static_cast<double>(readings.size() - kSettled));
}

void print(const VelocityCandidate& candidate, const char* quantity, const std::string& of,
           double value) {
  std::printf("%s,%g,%s,%s,%.4g\n", candidate.name.c_str(), candidate.setting_ms, quantity,
              of.c_str(), value);
}

void print_noise(const VelocityCandidate& candidate, const Motion& motion,
                 const std::string& timing, const std::vector<Reading>& readings) {
  const auto found_m_s = estimates(candidate, motion, readings);
  double best_m_s = 1e9, best_ms = 0.0;
  for (int quarters = 0; quarters <= 88; ++quarters) {
    const double lag_ms = 0.25 * quarters;
    const double left_m_s = noise_m_s(motion, readings, found_m_s, 1e-3 * lag_ms);
    if (left_m_s >= best_m_s) continue;
    best_m_s = left_m_s;
    best_ms = lag_ms;
  }
  print(candidate, "lag_ms", timing + "/" + motion.name, best_ms);
  print(candidate, "noise_mm_s", timing + "/" + motion.name, 1e3 * best_m_s);
}

/// A force by place and velocity on a device, for 3 s. Calls seen(place, force) over the last half
/// second.
void run(devices::PhantomModel device, const VelocityUpdate& update,
         const std::function<double(double, double)>& force_N,
         const std::function<void(double, double)>& seen) {
  for (std::uint64_t tick = 0; tick < 3000; ++tick) {
    const Eigen::Vector3d place_m = devices::read_encoders(device);
    const double asked_N = force_N(place_m.x(), update(tick * 1'000'000, place_m).x());
    devices::command_force(device, {asked_N, 0.0, 0.0});
    devices::advance_phantom(device, devices::kSubstepsPerTick);
    if (tick >= 2500) seen(device.position_m.x(), asked_N);
  }
}

/// Highest less lowest.
struct Range {
  double low = 1e300, high = -1e300;
  void add(double value) { low = std::min(low, value), high = std::max(high, value); }
  [[nodiscard]] double width() const { return high - low; }
};

devices::PhantomSettings still_device(int delay_ticks) {
  devices::PhantomSettings settings;
  settings.path.kind = devices::PathKind::kStill;
  settings.delay_ticks = delay_ticks;
  settings.start_velocity_m_s.x() = 0.02;
  return settings;
}

/// Whether 0.1 kg without damping of its own comes to rest under it, to four steps.
bool is_borne(const VelocityCandidate& candidate, int delay_ticks, double spring_N_per_m,
              double damper_N_s_per_m) {
  devices::PhantomSettings settings = still_device(delay_ticks);
  settings.device.mass_kg = 0.1;
  settings.device.resolution_m = kStep_m;
  Range moved_m;
  run(
      devices::make_phantom(settings), candidate.start(kStep_m),
      [&](double place_m, double velocity_m_s) {
        return -spring_N_per_m * place_m - damper_N_s_per_m * velocity_m_s;
      },
      [&](double place_m, double) { moved_m.add(place_m); });
  return moved_m.width() < 4.0 * kStep_m;
}

/// The last value, in steps of 3 %, up to which all are borne.
double last_borne(double first, double limit, const std::function<bool(double)>& borne) {
  double value = first;
  while (value < limit && borne(1.03 * value)) value *= 1.03;
  return value;
}

/// How much the friction on the smallest device swings, without a hand, pushed with half of it.
double chatter_N(const VelocityCandidate& candidate, double friction_N) {
  devices::PhantomSettings settings = still_device(0);
  settings.device = *devices::phantom_profile("touch");
  settings.push_N.x() = 0.5 * friction_N;
  const collision::ContactMaterial material = collision::tool_material({.friction = 1.0}, 0.05);
  Range force_N;
  run(
      devices::make_phantom(settings), candidate.start(settings.device.resolution_m),
      [&](double, double velocity_m_s) {
        return collision::friction_force_N(material, friction_N, {velocity_m_s, 0.0, 0.0}).x();
      },
      [&](double, double asked_N) { force_N.add(asked_N); });
  return force_N.width();
}

void compare(const std::filesystem::path& folder, bool is_small) {
  const auto lever = [&](const char* file) {
    devices::TrajectoryOptions options;
    options.map = devices::parse_axis_map("x_m:slave_rad*0.075");
    return devices::read_trajectory((folder / "teleop_1dof_2khz" / file).string(), options);
  };
  const std::string robot = (folder / "franka_1khz" / "franka_20260223_162545.csv").string();
  devices::TrajectoryOptions smaller;  // to a device's workspace
  smaller.scale = 0.15;
  std::vector<Motion> motions = {
      smooth("spring", 1, lever("m2_question1a_spring.csv"), 0.0),
      smooth("free", 1, lever("question1a_free_motion.csv"), 0.0),
      smooth("robot", 3, devices::read_trajectory(robot, smaller), 0.0),
      smooth("contour", 3,
             devices::read_trajectory((folder / "ku_contour_force" / "demo_a_1.csv").string()),
             0.035)};
  if (is_small) motions.erase(motions.begin() + 2, motions.end());
  const devices::Trajectory logged = devices::read_trajectory(robot);

  std::printf("# encoder steps of %g um, ticks of %g ms\n", 1e6 * kStep_m, 1e3 * kTick_s);
  std::printf("estimator,setting_ms,quantity,of,value\n");
  for (const VelocityCandidate& candidate : velocity_candidates()) {
    for (const Motion& motion : motions) {
      print_noise(candidate, motion, "even", even_readings(motion.end_s));
      print_noise(candidate, motion, "recorded", recorded_readings(logged, motion.end_s));
      if (!is_small) print_noise(candidate, motion, "stalls", stalled_readings(motion.end_s));
    }
    for (const int ticks : {0, 1, 2}) {
      if (is_small && ticks != 1) continue;
      const std::string late = std::to_string(ticks) + " ticks late";
      print(candidate, "damper_N_s_per_m", late,
            last_borne(2.0, 400.0, [&](double damper_N_s_per_m) {
              return is_borne(candidate, ticks, 0.0, damper_N_s_per_m);
            }));
      if (is_small) continue;
      print(candidate, "stiffness_N_per_m", late,
            last_borne(100.0, 1e5, [&](double spring_N_per_m) {
              return is_borne(candidate, ticks, spring_N_per_m, 2.0);
            }));
    }
    for (const double friction_N : {1.0, 1.65, 2.5}) {
      if (is_small) break;
      print(candidate, "chatter_N", std::to_string(friction_N).substr(0, 4) + " N",
            chatter_N(candidate, friction_N));
    }
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace stillgrid::performance

int main(int argc, char** argv) {
  const auto folder = stillgrid::devices::real_recordings();
  if (!std::filesystem::exists(folder)) {
    std::fprintf(stderr, "velocity_figures: expected $STILLGRID_DATA or ../shared/data\n");
    return 1;
  }
  stillgrid::performance::compare(folder, argc > 1 && std::string_view(argv[1]) == "--small");
}
