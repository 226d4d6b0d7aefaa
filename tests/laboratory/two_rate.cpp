#include "tests/laboratory/two_rate.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>

namespace stillgrid::laboratory::two_rate {
namespace {

using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

/// Snapshots that the display may need: the history, and one that is made but not yet shown.
constexpr int kSnapshots = static_cast<int>(proto::kHistoryLength) + 1;

/// Where each quantity stands in the state. Snapshots are counted back from the newest made.
struct Layout {
  int masses;

  static constexpr int kTool = 0;  // position, velocity
  [[nodiscard]] int positions() const { return 2; }
  [[nodiscard]] int velocities() const { return 2 + masses; }
  /// The touched mass's position.
  [[nodiscard]] int snapshot(int back) const {
    return back == 0 ? positions() : 1 + 2 * masses + back;
  }
  [[nodiscard]] int size() const { return 1 + 2 * masses + kSnapshots; }
};

MatrixXd stiffness_of(const Body& body) {
  MatrixXd stiffness = MatrixXd::Zero(body.masses, body.masses);
  for (int i = 0; i < body.masses; ++i) {
    stiffness(i, i) += body.link_N_per_m;
    if (i + 1 == body.masses) break;
    stiffness(i + 1, i + 1) += body.link_N_per_m;
    stiffness(i, i + 1) -= body.link_N_per_m;
    stiffness(i + 1, i) -= body.link_N_per_m;
  }
  return stiffness;
}

/// What implicit Euler over P divides impulses by, the body under no contact but `contact_N_per_m`.
MatrixXd step_inertia(const Body& body, double period_s, double contact_N_per_m) {
  MatrixXd inertia = period_s * period_s * stiffness_of(body);
  inertia(0, 0) += period_s * period_s * contact_N_per_m;
  inertia.diagonal().array() += body.mass_kg;
  return inertia;
}

/// Rows over a state: each mass's momentum after P under the forces as its positions stand.
MatrixXd momentum_rows(const Layout& at, const Body& body, double period_s) {
  MatrixXd rows = MatrixXd::Zero(body.masses, at.size());
  rows.middleCols(at.velocities(), body.masses).diagonal().array() = body.mass_kg;
  rows.middleCols(at.positions(), body.masses) = -period_s * stiffness_of(body);
  return rows;
}

/// One implicit Euler step of the body against the tool as it stands, and the new snapshot.
MatrixXd body_step(const Layout& at, const Body& body, double period_s, double contact_N_per_m) {
  const int n = body.masses;
  RowVectorXd contact = RowVectorXd::Zero(at.size());  // its force
  contact[Layout::kTool] = contact_N_per_m;
  contact[at.positions()] = -contact_N_per_m;
  // M v' = M v + P (contact - stiffness (c + P v')).
  MatrixXd momentum = momentum_rows(at, body, period_s);
  momentum.row(0) += period_s * contact;
  const MatrixXd velocity =
      step_inertia(body, period_s, contact_N_per_m).partialPivLu().solve(momentum);

  MatrixXd step = MatrixXd::Zero(at.size(), at.size());
  step.topLeftCorner<2, 2>().setIdentity();
  step.middleRows(at.velocities(), n) = velocity;
  step.middleRows(at.positions(), n) = period_s * velocity;
  step.block(at.positions(), at.positions(), n, n) += MatrixXd::Identity(n, n);
  for (int back = 1; back < kSnapshots; ++back)
    step(at.snapshot(back), at.snapshot(back - 1)) = 1.0;
  return step;
}

/// The force on the tool as a row over the state, the newest snapshot shown being `unshown`
/// snapshots old.
RowVectorXd tool_force(const Layout& at, const display::SnapshotWeights& displayed, int unshown,
                       double contact_N_per_m, const RowVectorXd& tool) {
  RowVectorXd shown = RowVectorXd::Zero(at.size());
  shown[at.snapshot(unshown)] += displayed.alpha;
  shown[at.snapshot(unshown + 1)] += 1.0 - displayed.alpha;
  return contact_N_per_m * (shown - tool);
}

}  // namespace

HeldTick held_tick(const Device& device) {
  Eigen::Matrix3d rate = Eigen::Matrix3d::Zero();
  rate(0, 1) = 1.0;
  rate.row(1) << -device.hand_N_per_m, -device.damping_N_s_per_m, 1.0;
  rate.row(1) /= device.mass_kg;
  // Its exponential by the series: terms fall below rounding well before the last.
  Eigen::Matrix3d exponential = Eigen::Matrix3d::Identity(), term = exponential;
  for (int i = 1; i < 30; ++i) {
    term = (term * rate * (kTick_s / i)).eval();
    exponential += term;
  }
  return {exponential.topLeftCorner<2, 2>(), exponential.topRightCorner<2, 1>()};
}

std::vector<Body> reacting_bodies() {
  std::vector<Body> bodies;
  for (const double mass_kg : {0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0})
    bodies.push_back({1, mass_kg, 0.0});
  bodies.push_back({10, 1e-3, 2000.0});
  bodies.push_back({10, 1e-2, 1000.0});
  return bodies;
}

MatrixXd monodromy(const Loop& loop, double contact_N_per_m) {
  const int period_ticks = static_cast<int>(loop.cycle.size());
  assert(period_ticks > 0 && loop.sample_age_ticks >= 0 && loop.sample_age_ticks <= period_ticks);
  const Layout at{loop.body.masses};
  const HeldTick tick = held_tick(loop.device);

  MatrixXd tool = MatrixXd::Identity(2, at.size());
  for (int i = 0; i < period_ticks; ++i) {
    const int since_display = i - loop.sample_age_ticks;
    const auto k = static_cast<std::size_t>((since_display + period_ticks) % period_ticks);
    const RowVectorXd force =
        tool_force(at, loop.cycle[k], since_display < 0 ? 1 : 0, contact_N_per_m, tool.row(0));
    tool = (tick.transition * tool + tick.input * force).eval();
  }
  MatrixXd after_step = MatrixXd::Identity(at.size(), at.size());
  after_step.topRows(2) = tool;
  return after_step * body_step(at, loop.body, period_ticks * kTick_s, contact_N_per_m);
}

MatrixXd held_force_monodromy(const Device& device, const Body& body, int period_ticks,
                              double contact_N_per_m) {
  const Layout at{body.masses};
  const HeldTick tick = held_tick(device);
  RowVectorXd force = RowVectorXd::Zero(at.size());
  force[at.positions()] = contact_N_per_m;
  force[Layout::kTool] = -contact_N_per_m;
  MatrixXd tool = MatrixXd::Identity(2, at.size());
  for (int i = 0; i < period_ticks; ++i)
    tool = (tick.transition * tool + tick.input * force).eval();
  MatrixXd map = body_step(at, body, period_ticks * kTick_s, contact_N_per_m);
  map.topRows(2) = tool;
  return map;
}

double spectral_radius(const MatrixXd& matrix) {
  // What nothing depends on, as snapshots that a law never shows, has eigenvalues of zero.
  MatrixXd read = matrix;
  for (;;) {
    std::vector<Eigen::Index> kept;
    for (Eigen::Index i = 0; i < read.cols(); ++i)
      if (!read.col(i).isZero(0.0)) kept.push_back(i);
    if (kept.empty()) return 0.0;
    if (static_cast<Eigen::Index>(kept.size()) == read.cols()) break;
    read = read(kept, kept).eval();
  }
  return Eigen::EigenSolver<MatrixXd>(read, false).eigenvalues().cwiseAbs().maxCoeff();
}

std::optional<StiffnessLimit> stiffness_limit(const std::function<MatrixXd(double)>& map,
                                              const StiffnessGrid& grid) {
  const auto is_stable = [&](double contact_N_per_m) {
    return spectral_radius(map(contact_N_per_m)) <= 1.0 + 1e-9;
  };
  const double ratio =
      std::pow(grid.highest_N_per_m / grid.lowest_N_per_m, 1.0 / (grid.points - 1));
  double stable_N_per_m = 0.0;
  for (int i = 0; i < grid.points; ++i) {
    double unstable_N_per_m = grid.lowest_N_per_m * std::pow(ratio, i);
    if (is_stable(unstable_N_per_m)) {
      stable_N_per_m = unstable_N_per_m;
      continue;
    }
    const double last_stable_N_per_m = stable_N_per_m;
    while (unstable_N_per_m - stable_N_per_m > 1e-7 * unstable_N_per_m) {
      const double between_N_per_m = 0.5 * (stable_N_per_m + unstable_N_per_m);
      (is_stable(between_N_per_m) ? stable_N_per_m : unstable_N_per_m) = between_N_per_m;
    }
    return StiffnessLimit{last_stable_N_per_m, stable_N_per_m};
  }
  return std::nullopt;
}

std::optional<StiffnessLimit> stiffness_limit(const Loop& loop, const StiffnessGrid& grid) {
  return stiffness_limit([&](double contact_N_per_m) { return monodromy(loop, contact_N_per_m); },
                         grid);
}

}  // namespace stillgrid::laboratory::two_rate
