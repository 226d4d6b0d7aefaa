#include "tests/laboratory/fit_run/held_press.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <span>
#include <stdexcept>
#include <utility>

#include "haptic_server/devices/phantom_model.hpp"
#include "sim_server/judge.hpp"
#include "sim_server/scene/build_world.hpp"
#include "tests/laboratory/verdict.hpp"

namespace stillgrid::fit_run {
namespace {

constexpr double kBefore_s = 1.0, kStay_s = 1.5, kWindow_s = 0.5, kStateInterval_s = 0.25;
constexpr double kOutside_m = 0.02, kApproach_s = 0.5;
constexpr double kNoise = 0.5;  // of an encoder step, the most that a reading is off by
constexpr const char* kHand = "light";

/// 1 at time zero, 0 from kApproach_s on, smooth.
double fade(double time_s) {
  const double to_go = std::clamp(1.0 - time_s / kApproach_s, 0.0, 1.0);
  return to_go * to_go * (3.0 - 2.0 * to_go);
}

/// Returns the path of the rows from begin_s on, approached from outside, and at its end so deep
/// that the hand's spring bears the last force and the device's friction.
std::vector<laboratory::PathPoint> press_path(std::span<const recording::TickRow> rows,
                                              double begin_s, const std::string& profile,
                                              double scale) {
  const devices::PhantomProfile device = *devices::phantom_profile(profile);
  const Eigen::Vector3d outward = rows.back().rendered_N.normalized();
  const double borne_N =
      std::min(rows.back().rendered_N.norm(), device.continuous_force_N) + device.friction_N;
  const double deeper_m = scale * borne_N / devices::hand_profile(kHand)->stiffness_N_per_m;
  // Where the hand presses at once it waits outside first: it takes time to come and to go deeper.
  const double wait_s = std::max(0.0, 2.0 * kApproach_s - rows.back().time_s + begin_s);
  const double length_s = rows.back().time_s - begin_s + wait_s;
  std::vector<laboratory::PathPoint> points;
  const auto add = [&](double time_s, const recording::TickRow& row) {
    const double out_m = fade(time_s) * kOutside_m - fade(length_s - time_s) * deeper_m;
    points.push_back({time_s, row.position_m + out_m * outward});
  };
  for (const recording::TickRow& row : rows) {
    if (row.time_s < begin_s) continue;
    if (points.empty() && wait_s > 0.0) add(0.0, row);
    add(row.time_s - begin_s + wait_s, row);
  }
  return points;
}

/// Along the worst axis the smaller of the largest rise and the largest fall: a swing from peak to
/// peak, and zero for a drift.
double to_and_fro(std::span<const recording::TickRow> rows) {
  Eigen::Array3d lowest = rows.front().position_m, highest = lowest;
  Eigen::Array3d rise = Eigen::Array3d::Zero(), fall = rise;
  for (const recording::TickRow& row : rows) {
    const Eigen::Array3d at = row.position_m;
    if (!at.allFinite()) return INFINITY;
    lowest = lowest.min(at);
    highest = highest.max(at);
    rise = rise.max(at - lowest);
    fall = fall.max(highest - at);
  }
  return rise.min(fall).maxCoeff();
}

/// The scene as it should feel.
Loop prompt(const Loop& loop) {
  return {.scene = sim_server::true_scene(loop.scene, 1000.0),
          .transition = display::Transition::kHold};
}

}  // namespace

Press::Press(Loop loop, std::string profile)
    : loop_(std::move(loop)),
      profile_(std::move(profile)),
      limit_m_(laboratory::kQuietEncoderSteps * devices::phantom_profile(profile_)->resolution_m *
               loop_.scene.device.scale) {
  const Loop truth = prompt(loop_);
  const sim_server::StartState start =
      sim_server::settled(truth.scene, scene::build_world(truth.scene));
  start_ = laboratory::state_of(start.world);
  laboratory::LabOptions options;
  options.device = "replay:file=" + loop_.scene.hand->file.string();
  options.transition = truth.transition;
  options.duration_s =
      sim_server::HandPath(loop_.scene.hand->file, loop_.scene.device).duration_s();
  options.start = &start_;
  options.state_interval_s = kStateInterval_s;
  const laboratory::LabRun run = laboratory::run_lab(truth.scene, options);
  const auto strongest = std::ranges::max_element(
      run.rows, {}, [](const recording::TickRow& row) { return row.rendered_N.squaredNorm(); });
  if (strongest == run.rows.end() || !(strongest->rendered_N.norm() > 0.0)) return;
  const double begun_s = start_.time_s;
  for (const laboratory::WorldState& state : run.states)
    if (state.time_s - begun_s <= std::max(0.0, strongest->time_s - kBefore_s)) start_ = state;
  path_ = press_path({run.rows.begin(), strongest + 1}, start_.time_s - begun_s, profile_,
                     loop_.scene.device.scale);
}

HeldPress Press::held(const Loop& loop, double margin, int seed) const {
  Loop stiff = loop;
  for (scene::MaterialDescription& material : stiff.scene.materials)
    material.contact_stiffness_N_per_m *= margin;
  const laboratory::PathFile path(loop.scene.device, path_);
  std::array<char, 200> device{};
  std::snprintf(device.data(), device.size(),
                "phantom:profile=%s,hand=%s,noise_m=%.9g,seed=%d,path=", profile_.c_str(), kHand,
                kNoise * devices::phantom_profile(profile_)->resolution_m, seed);
  laboratory::LabOptions options;
  options.device = device.data() + path.path().string();
  options.transition = loop.transition;
  options.latency_s = loop.latency_share * loop.scene.period_s;
  options.duration_s = path_.back().time_s + kStay_s;
  options.start = &start_;
  HeldPress held{.stable = false, .swing_m = INFINITY};
  try {
    const laboratory::LabRun run = laboratory::run_lab(stiff.scene, options);
    if (run.device_failed || run.rows.empty()) return held;
    const auto first = std::ranges::find_if(run.rows, [&](const recording::TickRow& row) {
      return row.time_s > run.rows.back().time_s - kWindow_s;
    });
    const std::span<const recording::TickRow> window(first, run.rows.end());
    held.swing_m = to_and_fro(window);
    held.drift_m = laboratory::swing_m(run.rows, kWindow_s);
    held.long_drift_m = laboratory::swing_m(run.rows, 2.0 * kWindow_s);
    held.stable = held.swing_m <= limit_m_ && held.drift_m <= limit_m_;
    const bool touches =
        std::ranges::any_of(window, [](const recording::TickRow& row) { return row.contacts > 0; });
    if (!touches) held.stable.reset();
  } catch (const std::domain_error&) {  // a place that is no number
  }
  return held;
}

HeldPress Press::at(double margin) const {
  if (path_.empty()) return {};
  HeldPress worst{.stable = true};
  for (int seed = 1; seed <= kSeeds && worst.stable == true; ++seed) {
    HeldPress found = held(loop_, margin, seed);
    if (found.stable != true) {
      const HeldPress truth = held(prompt(loop_), margin, seed);
      found.truth_swing_m = truth.swing_m;
      if (!found.stable && truth.stable)
        found.stable = false;  // lost what can be held
      else if (found.stable && truth.stable && std::isfinite(found.swing_m))
        found.stable = found.swing_m <= std::max(limit_m_, 2.0 * truth.swing_m) &&
                       found.drift_m <= std::max(limit_m_, 2.0 * truth.long_drift_m);
    }
    if (found.stable != true || found.swing_m >= worst.swing_m) worst = found;
  }
  return worst;
}

std::optional<double> Press::largest_margin() const {
  std::optional<double> largest;
  for (int i = 0; i <= 12; ++i) {
    const double margin = std::round(100.0 * std::pow(2.0, i / 3.0)) / 100.0;
    if (at(margin).stable != true) break;
    largest = margin;
  }
  return largest;
}

}  // namespace stillgrid::fit_run
