#include "sim_server/spheres/force_fit.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sim_server/spheres/ball_grid.hpp"

namespace stillgrid::spheres {
namespace {

constexpr Eigen::Index kUnknowns = 4;  // of a ball: its radius and its centre

/// A ball that the tool touches at a place: how the force there changes with it.
struct Touch {
  std::uint32_t ball;
  Eigen::Vector3d away;  // unit, from the ball's centre to the tool's
  double turn;           // depth over distance: how far the push turns with the centre
};

/// The balls' forces at all places, less what they should be, and their Jacobian as touches.
struct Linearised {
  std::vector<Touch> touches;
  std::vector<std::size_t> starts;  // places + 1, into touches
  Eigen::VectorXd missing_m;        // three a place
};

/// d force / d radius = away; d force / d centre = away away^T - turn (1 - away away^T).
Eigen::Vector3d change_of(const Touch& touch, const Eigen::VectorXd& step) {
  const Eigen::Index first = kUnknowns * static_cast<Eigen::Index>(touch.ball);
  const Eigen::Vector3d moved = step.segment<3>(first + 1);
  const double along = touch.away.dot(moved);
  return (step[first] + (1.0 + touch.turn) * along) * touch.away - touch.turn * moved;
}

void add_transposed(const Touch& touch, const Eigen::Vector3d& change, Eigen::VectorXd& sum) {
  const Eigen::Index first = kUnknowns * static_cast<Eigen::Index>(touch.ball);
  const double along = touch.away.dot(change);
  sum[first] += along;
  sum.segment<3>(first + 1) += (1.0 + touch.turn) * along * touch.away - touch.turn * change;
}

class ForceFit {
 public:
  ForceFit(std::span<const Ball> balls, const ExactForces& exact, double tool_radius_m,
           double stiffness_scale)
      : balls_(balls.begin(), balls.end()),
        exact_(exact),
        tool_radius_m_(tool_radius_m),
        share_(1.0 / stiffness_scale) {}

  std::vector<Ball> run() {
    constexpr int kMaxSteps = 12;
    constexpr double kEnough = 2e-3;  // of the squares, in a step
    for (int step = 0; step < kMaxSteps; ++step) {
      linearise();
      const double before_m2 = now_.missing_m.squaredNorm();
      if (!take_step(before_m2) || before_m2 - last_m2_ < kEnough * before_m2) break;
    }
    return balls_;
  }

 private:
  void linearise();
  [[nodiscard]] double squares_m2(const std::vector<Ball>& balls) const;
  [[nodiscard]] Eigen::VectorXd solve() const;
  [[nodiscard]] std::vector<Ball> moved(const Eigen::VectorXd& step) const;

  /// Takes the step that lessens the squares, damped until one does; false where none does.
  bool take_step(double before_m2) {
    constexpr int kTries = 6;
    for (int attempt = 0; attempt < kTries; ++attempt, damping_ *= 5.0) {
      std::vector<Ball> next = moved(solve());
      last_m2_ = squares_m2(next);
      if (!(last_m2_ < before_m2)) continue;
      balls_ = std::move(next);
      damping_ = std::max(1e-6, 0.3 * damping_);
      return true;
    }
    return false;
  }

  std::vector<Ball> balls_;
  const ExactForces& exact_;
  double tool_radius_m_;
  double share_;  // of the mesh's force that the springs of 1 N/m should have
  double damping_ = 1e-3;
  double last_m2_ = 0.0;
  Linearised now_;
};

void ForceFit::linearise() {
  const BallBody body = make_ball_body(balls_, tool_radius_m_);
  const std::size_t places = exact_.tool_m.size();
  now_.touches.clear();
  now_.starts.assign(1, 0);
  now_.missing_m.resize(3 * static_cast<Eigen::Index>(places));
  for (std::size_t place = 0; place < places; ++place) {
    Eigen::Vector3d missing_m = share_ * exact_.force_m[place];
    for (const std::uint32_t i : balls_near(body.grid, exact_.tool_m[place])) {
      const Eigen::Vector3d apart_m = exact_.tool_m[place] - balls_[i].centre_m;
      const double distance_m = apart_m.norm(),
                   depth_m = balls_[i].radius_m + tool_radius_m_ - distance_m;
      if (!(depth_m > 0.0) || !(distance_m > 0.0)) continue;
      now_.touches.push_back({i, apart_m / distance_m, depth_m / distance_m});
      missing_m -= depth_m / distance_m * apart_m;
    }
    now_.starts.push_back(now_.touches.size());
    now_.missing_m.segment<3>(3 * static_cast<Eigen::Index>(place)) = missing_m;
  }
}

double ForceFit::squares_m2(const std::vector<Ball>& balls) const {
  const BallBody body = make_ball_body(balls, tool_radius_m_);
  double sum_m2 = 0.0;
  for (std::size_t place = 0; place < exact_.tool_m.size(); ++place)
    sum_m2 +=
        (share_ * exact_.force_m[place] - unit_force_m(body, exact_.tool_m[place])).squaredNorm();
  return sum_m2;
}

/// Conjugate gradients on (J^T J + damping diag) step = J^T missing, preconditioned by the
/// diagonal.
Eigen::VectorXd ForceFit::solve() const {
  constexpr int kMaxRounds = 40;
  constexpr double kResidual = 1e-3;
  const Eigen::Index size = kUnknowns * static_cast<Eigen::Index>(balls_.size());
  Eigen::VectorXd residual = Eigen::VectorXd::Zero(size), diagonal = residual;
  const auto for_each_place = [&](auto&& visit) {
    for (std::size_t place = 0; place + 1 < now_.starts.size(); ++place)
      visit(std::span(now_.touches)
                .subspan(now_.starts[place], now_.starts[place + 1] - now_.starts[place]),
            3 * static_cast<Eigen::Index>(place));
  };
  for_each_place([&](std::span<const Touch> touches, Eigen::Index row) {
    for (const Touch& touch : touches) {
      add_transposed(touch, now_.missing_m.segment<3>(row), residual);
      const Eigen::Index first = kUnknowns * static_cast<Eigen::Index>(touch.ball);
      diagonal[first] += 1.0;
      diagonal.segment<3>(first + 1).array() +=
          (1.0 - touch.turn * touch.turn) * touch.away.array().square() + touch.turn * touch.turn;
    }
  });
  // A ball that nothing touches must not move.
  const Eigen::VectorXd damped =
      damping_ * (diagonal.array() + 1e-3 * diagonal.mean() + 1e-12).matrix();
  const Eigen::VectorXd inverse = (diagonal + damped).cwiseInverse();
  Eigen::VectorXd step = Eigen::VectorXd::Zero(size), search = inverse.cwiseProduct(residual);
  double energy = residual.dot(search);
  const double enough = kResidual * residual.norm();
  for (int round = 0; round < kMaxRounds && residual.norm() > enough; ++round) {
    Eigen::VectorXd product = damped.cwiseProduct(search);
    for_each_place([&](std::span<const Touch> touches, Eigen::Index) {
      Eigen::Vector3d change = Eigen::Vector3d::Zero();
      for (const Touch& touch : touches) change += change_of(touch, search);
      for (const Touch& touch : touches) add_transposed(touch, change, product);
    });
    const double length = energy / search.dot(product);
    step += length * search;
    residual -= length * product;
    const Eigen::VectorXd scaled = inverse.cwiseProduct(residual);
    const double next = residual.dot(scaled);
    search = scaled + next / energy * search;
    energy = next;
  }
  return step;
}

std::vector<Ball> ForceFit::moved(const Eigen::VectorXd& step) const {
  std::vector<Ball> balls = balls_;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Eigen::Index first = kUnknowns * static_cast<Eigen::Index>(i);
    const double most_m = 0.5 * std::min(tool_radius_m_, balls[i].radius_m);
    const Eigen::Vector3d moved_m = step.segment<3>(first + 1);
    balls[i].radius_m += std::clamp(step[first], -most_m, most_m);
    balls[i].centre_m += std::min(1.0, most_m / std::max(moved_m.norm(), 1e-300)) * moved_m;
  }
  return balls;
}

}  // namespace

std::vector<Ball> fit_force(std::span<const Ball> balls, const ExactForces& exact,
                            double tool_radius_m) {
  const BallBody body = make_ball_body(balls, tool_radius_m);
  const FeltError before =
      felt_error(exact, [&](const Eigen::Vector3d& tool_m) { return unit_force_m(body, tool_m); });
  if (!(before.stiffness_scale > 0.0)) return {balls.begin(), balls.end()};
  return ForceFit(balls, exact, tool_radius_m, before.stiffness_scale).run();
}

}  // namespace stillgrid::spheres
