#include "tests/performance/velocity_rivals.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>
#include <initializer_list>

#include "shared/rendering/velocity_estimator.hpp"

namespace stillgrid::performance {
namespace {

struct Sample {
  double time_s;
  double position_m;
};
using History = std::deque<Sample>;  // newest first

/// One axis of a rival: its estimate after the newest sample.
using AxisUpdate = std::function<double(const History&)>;

double slope(const Sample& from, const Sample& to) {
  return (to.position_m - from.position_m) / (to.time_s - from.time_s);
}

/// Three axes with the samples of the last 70 ms. Each axis is made anew, for it has a state.
VelocityUpdate three_axes(const std::function<AxisUpdate()>& make_axis) {
  struct Axis {
    History history;
    AxisUpdate update;
  };
  std::vector<Axis> axes(3);
  for (Axis& axis : axes) axis.update = make_axis();
  return [axes](std::uint64_t time_ns, const Eigen::Vector3d& position_m) mutable {
    Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
    const double time_s = 1e-9 * static_cast<double>(time_ns);
    for (Eigen::Index i = 0; i < 3; ++i) {
      auto& [history, update] = axes[static_cast<std::size_t>(i)];
      history.push_front({time_s, position_m[i]});
      while (history.size() > 2 && time_s - history.back().time_s > 0.07) history.pop_back();
      if (history.size() > 1) velocity_m_s[i] = update(history);
    }
    return velocity_m_s;
  };
}

/// How many of the newest samples lie within window_s, and the first beyond: two at least.
std::size_t within(const History& history, double window_s) {
  std::size_t count = 2;
  while (count < history.size() && history[0].time_s - history[count - 1].time_s < window_s - 1e-9)
    ++count;
  return count;
}

struct Line {
  double at_zero_m, slope_m_s;
};

/// Least squares through the newest samples; time counts from the newest.
Line fit(const History& history, std::size_t count) {
  const auto n = static_cast<double>(count);
  double mean_s = 0.0, mean_m = 0.0, spread = 0.0, product = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    mean_s += (history[i].time_s - history[0].time_s) / n;
    mean_m += history[i].position_m / n;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double off_s = history[i].time_s - history[0].time_s - mean_s;
    spread += off_s * off_s;
    product += off_s * (history[i].position_m - mean_m);
  }
  return {mean_m - product / spread * mean_s, product / spread};
}

Line through_ends(const History& history, std::size_t count) {
  return {history[0].position_m, slope(history[count - 1], history[0])};
}

bool runs_through(const Line& line, const History& history, std::size_t count, double bound_m) {
  return std::all_of(
      history.begin(), history.begin() + static_cast<std::ptrdiff_t>(count), [&](const Sample& s) {
        const double on_line_m = line.at_zero_m + line.slope_m_s * (s.time_s - history[0].time_s);
        return std::abs(on_line_m - s.position_m) <= bound_m * (1.0 + 1e-9);
      });
}

AxisUpdate adaptive(Line (*line_of)(const History&, std::size_t), double longest_s,
                    double bound_m) {
  return [=](const History& history) {
    double found_m_s = slope(history[1], history[0]);
    const std::size_t most = within(history, longest_s);
    for (std::size_t count = 3; count <= most; ++count) {
      const Line line = line_of(history, count);
      if (!runs_through(line, history, count, bound_m)) break;
      found_m_s = line.slope_m_s;
    }
    return found_m_s;
  };
}

AxisUpdate low_passes(int stages, double time_constant_s) {
  return [=, state = std::vector<double>(static_cast<std::size_t>(stages))](
             const History& history) mutable {
    const double step_s = history[0].time_s - history[1].time_s;
    double rate = slope(history[1], history[0]);
    for (double& stage : state) {
      stage += (1.0 - std::exp(-step_s / time_constant_s)) * (rate - stage);
      rate = stage;
    }
    return rate;
  };
}

AxisUpdate constant_acceleration(double time_constant_s) {
  return [=, is_started = false,
          state = Eigen::Vector3d(0.0, 0.0, 0.0)](const History& history) mutable {
    const double step_s = history[0].time_s - history[1].time_s;
    if (!is_started) state[0] = history[1].position_m;
    is_started = true;
    const double kept = std::exp(-step_s / time_constant_s), left = 1.0 - kept;
    state[0] += step_s * (state[1] + 0.5 * step_s * state[2]);
    state[1] += step_s * state[2];
    const double off_m = history[0].position_m - state[0];
    state[0] += (1.0 - kept * kept * kept) * off_m;
    state[1] += 1.5 * left * left * (1.0 + kept) * off_m / step_s;
    state[2] += left * left * left * off_m / (step_s * step_s);
    return state[1];
  };
}

/// A rival on one axis, by setting and resolution.
using MakeAxis = std::function<AxisUpdate(double setting_s, double resolution_m)>;

void add(std::vector<VelocityCandidate>& candidates, const std::string& name,
         std::initializer_list<double> settings_ms, const MakeAxis& make_axis) {
  for (const double setting_ms : settings_ms)
    candidates.push_back({name, setting_ms, [=](double resolution_m) {
                            return three_axes(
                                [=] { return make_axis(1e-3 * setting_ms, resolution_m); });
                          }});
}

}  // namespace

std::vector<VelocityCandidate> velocity_candidates() {
  std::vector<VelocityCandidate> all;
  all.push_back({"product", 5.0, [](double) -> VelocityUpdate {
                   return [estimator = rendering::VelocityEstimator()](
                              std::uint64_t time_ns, const Eigen::Vector3d& position_m) mutable {
                     return estimator.update(time_ns, position_m);
                   };
                 }});
  add(all, "difference", {0.0}, [](double, double) -> AxisUpdate {
    return [](const History& history) { return slope(history[1], history[0]); };
  });
  add(all, "window", {5.0, 10.0, 15.0, 25.0}, [](double window_s, double) -> AxisUpdate {
    return [=](const History& history) {
      return slope(history[within(history, window_s) - 1], history[0]);
    };
  });
  add(all, "low-pass", {2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 12.0},
      [](double time_s, double) { return low_passes(1, time_s); });
  add(all, "two low-passes", {1.5, 2.0, 2.5, 3.0, 4.0, 6.0},
      [](double time_s, double) { return low_passes(2, time_s); });
  add(all, "line fit", {5.0, 6.0, 8.0, 10.0, 15.0, 25.0},
      [](double window_s, double) -> AxisUpdate {
        return [=](const History& history) {
          return fit(history, within(history, window_s)).slope_m_s;
        };
      });
  add(all, "constant acceleration", {2.5, 3.0, 4.0, 5.0, 6.0, 9.0},
      [](double time_s, double) { return constant_acceleration(time_s); });
  add(all, "adaptive end fit", {5.0, 10.0, 16.0, 25.0, 40.0},
      [](double longest_s, double step_m) { return adaptive(through_ends, longest_s, step_m); });
  add(all, "adaptive best fit", {5.0, 10.0, 16.0, 25.0, 40.0},
      [](double longest_s, double step_m) { return adaptive(fit, longest_s, step_m); });
  return all;
}

}  // namespace stillgrid::performance
