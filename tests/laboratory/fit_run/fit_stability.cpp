#include "tests/laboratory/fit_run/fit_stability.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "haptic_server/devices/phantom_model.hpp"
#include "tests/laboratory/fit_run/fit_error.hpp"
#include "tests/laboratory/path_file.hpp"
#include "tests/laboratory/stable_stiffness.hpp"
#include "tests/laboratory/verdict.hpp"

namespace stillgrid::fit_run {
namespace {

constexpr double kStay_s = 1.5, kWindow_s = 0.5;
constexpr double kOutside_m = 0.02, kApproach_s = 0.5;
constexpr double kNoise = 0.5;  // of an encoder step, that a reading is off by at most
constexpr double kMaxMargin = 16.0;
constexpr const char* kHand = "light";

/// 1 at time zero, 0 from kApproach_s on, smooth.
double fade(double time_s) {
  const double to_go = std::clamp(1.0 - time_s / kApproach_s, 0.0, 1.0);
  return to_go * to_go * (3.0 - 2.0 * to_go);
}

/// The reference's path from where a press begins, come to from outside. Where it presses at once
/// the tool waits there first, for it takes time to come and to go deeper.
std::vector<laboratory::PathPoint> press_path(const FitReference& reference,
                                              const ReferencePress& press) {
  std::vector<laboratory::PathPoint> points;
  Eigen::Vector3d outward = Eigen::Vector3d::Zero();
  const double wait_s = std::max(0.0, 2.0 * kApproach_s - (press.press_s - press.begin_s));
  for (const recording::TickRow& row : reference.rows) {
    if (row.time_s < press.begin_s) continue;
    if (row.time_s > press.press_s) break;
    const double time_s = row.time_s - press.begin_s + wait_s;
    if (points.empty()) {
      outward = row.rendered_N.normalized();  // zero stays zero
      if (wait_s > 0.0) points.push_back({0.0, row.position_m + kOutside_m * outward});
    }
    points.push_back({time_s, row.position_m + fade(time_s) * kOutside_m * outward});
  }
  return points;
}

/// Where the hand means to go on that path: at its end so much deeper that the hand's spring bears
/// the reference's force, or what the device can exert for long where that is less, and the
/// device's friction.
std::vector<laboratory::PathPoint> meant_path(std::vector<laboratory::PathPoint> points,
                                              const FitReference& reference,
                                              const ReferencePress& press,
                                              const std::string& profile, double scale) {
  const auto last = std::upper_bound(
      reference.rows.begin(), reference.rows.end(), press.press_s,
      [](double time_s, const recording::TickRow& row) { return time_s < row.time_s; });
  const Eigen::Vector3d force_N = std::prev(last)->rendered_N;
  const devices::PhantomProfile device = *devices::phantom_profile(profile);
  const double borne_N = std::min(force_N.norm(), device.continuous_force_N) + device.friction_N;
  const Eigen::Vector3d deeper_m =
      -scale * borne_N / devices::hand_profile(kHand)->stiffness_N_per_m * force_N.normalized();
  const double end_s = points.back().time_s;
  for (laboratory::PathPoint& point : points)
    point.position_m += fade(end_s - point.time_s) * deeper_m;
  return points;
}

void stiffen(scene::SceneDescription& scene, double margin) {
  for (scene::MaterialDescription& material : scene.materials)
    material.contact_stiffness_N_per_m *= margin;
}

/// How a scene is simulated and shown while it is pressed.
struct Loop {
  scene::SceneDescription scene;
  display::Transition transition = display::Transition::kHold;
  double latency_s = 0.0;
};

/// As the reference is simulated and shown, but for the margin.
Loop low_latency_loop(const scene::SceneDescription& given, double margin) {
  Loop low_latency{.scene = reference_scene(given, 1)};
  stiffen(low_latency.scene, margin);
  return low_latency;
}

/// A press by that device, PLUGIN and options, but for its path. It ends at the path's end, or
/// stays.
laboratory::LabRun run_press(const Loop& loop, const ReferencePress& press,
                             const std::vector<laboratory::PathPoint>& points,
                             const std::string& device, double stay_s) {
  const laboratory::PathFile path(loop.scene.device, points);
  laboratory::LabOptions options;
  options.device = device + path.path().string();
  options.transition = loop.transition;
  options.latency_s = loop.latency_s;
  options.duration_s = points.back().time_s + stay_s;
  options.start = &press.world;
  return laboratory::run_lab(loop.scene, options);
}

struct HeldPress {
  double swing_m = std::numeric_limits<double>::infinity();
  double contact_share = 0.0;
  double drift_m = 0.0, late_drift_m = 0.0;  // over two windows, and over the last
};

std::span<const recording::TickRow> window_of(const laboratory::LabRun& run) {
  const auto first =
      std::find_if(run.rows.begin(), run.rows.end(), [&](const recording::TickRow& row) {
        return row.time_s > run.rows.back().time_s - kWindow_s;
      });
  return {first, run.rows.end()};
}

/// Along the worst axis the less of the largest rise and the largest fall: of a swing from peak to
/// peak, nothing of a drift however far.
double to_and_fro(std::span<const recording::TickRow> rows,
                  const Eigen::Vector3d recording::TickRow::*of) {
  Eigen::Array3d lowest = rows.front().*of, highest = lowest;
  Eigen::Array3d rise = Eigen::Array3d::Zero(), fall = rise;
  for (const recording::TickRow& row : rows) {
    const Eigen::Array3d at = row.*of;
    if (!at.allFinite()) return std::numeric_limits<double>::infinity();
    lowest = lowest.min(at);
    highest = highest.max(at);
    rise = rise.max(at - lowest);
    fall = fall.max(highest - at);
  }
  return rise.min(fall).maxCoeff();
}

/// PLUGIN and options but for the path, with the limits that the device declares.
std::string held_device(const std::string& profile, int seed) {
  std::array<char, 200> spec{};
  std::snprintf(spec.data(), spec.size(),
                "phantom:profile=%s,hand=%s,noise_m=%.9g,seed=%d,path=", profile.c_str(), kHand,
                kNoise * devices::phantom_profile(profile)->resolution_m, seed);
  return spec.data();
}

HeldPress hold_press(const Loop& loop, const ReferencePress& press, const FitReference& reference,
                     const std::string& profile, int seed) {
  const std::vector<laboratory::PathPoint> points =
      meant_path(press_path(reference, press), reference, press, profile, loop.scene.device.scale);
  HeldPress held;
  try {
    const laboratory::LabRun run =
        run_press(loop, press, points, held_device(profile, seed), kStay_s);
    if (run.device_failed || run.rows.empty()) return held;
    const auto window = window_of(run);
    const auto touching = std::count_if(window.begin(), window.end(), touches);
    held.contact_share = static_cast<double>(touching) / static_cast<double>(window.size());
    held.drift_m = laboratory::swing_m(run.rows, 2.0 * kWindow_s);
    held.late_drift_m = laboratory::swing_m(run.rows, kWindow_s);
    // A body that is thrown off and comes back later is no drift.
    held.swing_m = held.contact_share == 1.0 ? to_and_fro(window, &recording::TickRow::position_m)
                                             : held.late_drift_m;
  } catch (const std::domain_error&) {  // a place that is no number
  }
  return held;
}

/// How far the force on a tool that is held fast would move the hand's spring to and fro.
double spring_swing_m(const Loop& loop, const ReferencePress& press,
                      std::vector<laboratory::PathPoint> points) {
  points.push_back({points.back().time_s + kStay_s, points.back().position_m});
  const laboratory::LabRun run = run_press(loop, press, points, "replay:file=", 0.0);
  return loop.scene.device.scale * to_and_fro(window_of(run), &recording::TickRow::rendered_N) /
         devices::hand_profile(kHand)->stiffness_N_per_m;
}

}  // namespace

HeldPresses::HeldPresses(const FitCandidate& candidate, double latency_share,
                         const FitReference& reference, GivenScene given, std::string profile)
    : candidate_(candidate),
      latency_share_(latency_share),
      reference_(reference),
      given_(std::move(given)),
      profile_(std::move(profile)),
      limit_m_(laboratory::kQuietEncoderSteps * devices::phantom_profile(profile_)->resolution_m *
               candidate.scene.device.scale) {}

double HeldPresses::own_swing_m(const ReferencePress& press, double margin, int seed) const {
  const Loop low_latency = low_latency_loop(given_(), margin);
  double held_fast_m = 0.0;
  try {
    held_fast_m = spring_swing_m(low_latency, press, press_path(reference_, press));
  } catch (const std::domain_error&) {  // a scene that falls apart by itself excuses nothing
  }
  if (2.0 * held_fast_m <= limit_m_) return held_fast_m;  // the scene stands still
  return std::min(held_fast_m, hold_press(low_latency, press, reference_, profile_, seed).swing_m);
}

FitStability HeldPresses::at(double margin) const {
  FitStability worst = at_seed(margin, 1);
  for (int seed = 2; seed <= kSeeds && worst.stable == true; ++seed) {
    const FitStability found = at_seed(margin, seed);
    if (found.stable == false || (found.stable == true && found.swing_m > worst.swing_m))
      worst = found;
  }
  return worst;
}

FitStability HeldPresses::at_seed(double margin, int seed) const {
  Loop loop{candidate_.scene, candidate_.transition, latency_share_ * candidate_.scene.period_s};
  stiffen(loop.scene, margin);
  FitStability worst;
  for (const ReferencePress& press : reference_.presses) {
    const HeldPress held = hold_press(loop, press, reference_, profile_, seed);
    FitStability found{.stable = std::nullopt,
                       .swing_m = held.swing_m,
                       .reference_swing_m = std::nullopt,
                       .contact_share = held.contact_share};
    if (held.swing_m > limit_m_) {
      found.reference_swing_m = own_swing_m(press, margin, seed);
      if (!std::isfinite(held.swing_m) || held.swing_m > 2.0 * *found.reference_swing_m) {
        found.stable = false;
        return found;
      }
    }
    if (held.late_drift_m > limit_m_ || !(held.contact_share > 0.0)) {
      const HeldPress truth =
          hold_press(low_latency_loop(given_(), margin), press, reference_, profile_, seed);
      if (held.late_drift_m > limit_m_ && held.late_drift_m > 2.0 * truth.drift_m)
        found = {false, held.late_drift_m, truth.drift_m, held.contact_share};
      else if (!(held.contact_share > 0.0) && truth.contact_share > 0.0)
        found.stable = false;  // threw off what can be held
      if (found.stable) return found;
      if (!(held.contact_share > 0.0)) continue;
    }
    found.stable = true;
    if (!worst.stable || found.swing_m >= worst.swing_m) worst = found;
  }
  return worst;
}

std::optional<double> HeldPresses::largest_margin() const {
  // As it is told, so that it can be asked for again.
  const auto rounded = [](double margin) { return std::round(100.0 * margin) / 100.0; };
  const double step = std::cbrt(2.0);
  auto largest = laboratory::largest_stable_stiffness_N_per_m(
      [&](double margin) { return at_seed(rounded(margin), 1).stable == true; },
      {.lowest_N_per_m = 1.0, .highest_N_per_m = 1.001 * kMaxMargin, .step = step});
  // Found by one seed, it is what all of them hold.
  while (largest && at(rounded(*largest)).stable != true)
    largest = *largest > 1.0 + 1e-9 ? std::optional(*largest / step) : std::nullopt;
  return largest ? std::optional(rounded(*largest)) : std::nullopt;
}

}  // namespace stillgrid::fit_run
