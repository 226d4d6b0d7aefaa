#include "sim_server/dynamics/step/contact_response.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <utility>

namespace stillgrid::dynamics {
namespace {

/// Of an answer, relative: the response errs by its square.
constexpr double kAccuracy = 1e-2;
/// Of what resists the most, below which a mode is none.
constexpr double kLeastResistance = 1e-8;
/// What does not overlap counts by this, the rest by its depth.
constexpr double kLeastDepth_m = 1e-6;

constexpr int kModes = static_cast<int>(proto::kMaxModes);
using Small =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kModes, kModes>;

double weight_m(const ToolTouch& touch) {
  return std::max(touch.depth_m, kLeastDepth_m);
}

/// Columns that are orthonormal by `gram`, of all that is not too little of it.
Small orthonormal(const Small& gram) {
  const Eigen::VectorXd scale = gram.diagonal().cwiseSqrt().cwiseInverse();
  const Small scaled = scale.asDiagonal() * gram * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Small> found(scaled);
  const Eigen::VectorXd& values = found.eigenvalues();
  Eigen::Index dropped = 0;
  while (dropped + 1 < values.size() &&
         !(values[dropped] > kLeastResistance * values[values.size() - 1]))
    ++dropped;
  const Eigen::Index kept = values.size() - dropped;
  return scale.asDiagonal() * found.eigenvectors().rightCols(kept) *
         values.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
}

}  // namespace

void ContactResponse::group(std::span<const ToolTouch> touches) {
  touches_.assign(touches.begin(), touches.end());
  std::stable_sort(touches_.begin(), touches_.end(), [](const ToolTouch& a, const ToolTouch& b) {
    return a.sphere->body != b.sphere->body ? a.sphere->body < b.sphere->body
                                            : a.depth_m > b.depth_m;
  });
  groups_.clear();
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    if (i == 0 || touches_[i].sphere->body != touches_[i - 1].sphere->body)
      groups_.push_back({i, i, touches_[i].depth_m, 0.0});
    groups_.back().last = i + 1;
    groups_.back().weight_m += weight_m(touches_[i]);
  }
  std::stable_sort(groups_.begin(), groups_.end(),
                   [](const Group& a, const Group& b) { return a.depth_m > b.depth_m; });
}

Eigen::VectorXd& ContactResponse::add_push(const MechanicalSystem& system) {
  if (pushes_.size() == push_count_) pushes_.emplace_back();
  return pushes_[push_count_++].setZero(system.size());
}

/// A body as it is pressed, in three directions.
void ContactResponse::push_together(const MechanicalSystem& system, const Group& group) {
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::VectorXd& push = add_push(system);
    for (std::size_t i = group.first; i < group.last; ++i)
      system.push_sphere(*touches_[i].sphere,
                         weight_m(touches_[i]) / group.weight_m * Eigen::Vector3d::Unit(axis),
                         Eigen::Vector3d::Zero(), push);
  }
}

/// Each body, the deepest first; then how rigid ones turn, and of soft ones how each contact gives
/// way by itself.
void ContactResponse::find_pushes(const MechanicalSystem& system) {
  push_count_ = 0;
  const auto has_room = [&] { return push_count_ + 3 <= proto::kMaxModes; };
  for (const Group& group : groups_)
    if (has_room()) push_together(system, group);
  for (const Group& group : groups_) {
    const bool is_rigid = touches_[group.first].sphere->rigid >= 0;
    const std::size_t touches = group.last - group.first;
    const std::size_t more = is_rigid ? 1 : touches > 1 ? touches : 0;
    for (std::size_t i = group.first; i < group.first + more && has_room(); ++i)
      for (int axis = 0; axis < 3; ++axis) {
        const bodies::SphereBinding& sphere = *touches_[i].sphere;
        const Eigen::Vector3d unit = Eigen::Vector3d::Unit(axis), none = Eigen::Vector3d::Zero();
        system.push_sphere(sphere, is_rigid ? none : unit, is_rigid ? unit : none,
                           add_push(system));
      }
  }
}

void ContactResponse::answer_pushes(ImplicitStage& stage, const Budget& budget) {
  answer_count_ = 0;
  bool is_linear = false;
  for (std::size_t i = 0; i < push_count_; ++i) {
    const Eigen::VectorXd& push = pushes_[i];
    if (push.isZero(0.0) || budget.is_late()) continue;
    if (answers_.size() == answer_count_) answers_.emplace_back();
    auto& [motion, resisted] = answers_[answer_count_];
    const bool is_solved =
        is_linear ? solver_.solve_another(stage, push, kAccuracy, budget, motion)
                  : solver_.solve(stage, JacobianKind::kDefinite, push, kAccuracy, budget, motion);
    if (!is_solved) continue;
    is_linear = true;
    resisted.resize(push.size());
    stage.multiply(motion, resisted);
    if (motion.dot(resisted) > 0.0) ++answer_count_;
  }
}

void ContactResponse::find_modes(const MechanicalSystem& system, const ImplicitStage& stage,
                                 double step_s, const Eigen::VectorXd& velocity) {
  const std::size_t count = answer_count_;
  const auto size = static_cast<Eigen::Index>(count);
  Small resistance(size, size), inertia(size, size);
  for (std::size_t j = 0; j < count; ++j) {
    system.momentum(answers_[j].motion, momentum_);
    for (std::size_t i = 0; i <= j; ++i) {
      const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(j);
      resistance(row, column) = resistance(column, row) =
          answers_[i].motion.dot(answers_[j].resisted);
      inertia(row, column) = inertia(column, row) = answers_[i].motion.dot(momentum_);
    }
  }
  const Small basis = orthonormal(resistance);
  const Small shares = basis.transpose() * inertia * basis;
  const Eigen::SelfAdjointEigenSolver<Small> by_inertia(shares);
  const Small combined = basis * by_inertia.eigenvectors();

  const Eigen::VectorXd at_start = stage.initial_guess();
  motions_.resize(static_cast<std::size_t>(combined.cols()));
  for (Eigen::Index mode = 0; mode < combined.cols(); ++mode) {
    Eigen::VectorXd& motion = motions_[static_cast<std::size_t>(mode)].setZero(system.size());
    double displacement = 0.0, at_velocity = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      const double part = combined(static_cast<Eigen::Index>(i), mode);
      motion += step_s * part * answers_[i].motion;
      displacement += part * answers_[i].resisted.dot(velocity);
      at_velocity += part * answers_[i].resisted.dot(at_start);
    }
    modes_.push_back({static_cast<float>(std::clamp(by_inertia.eigenvalues()[mode], 0.0, 1.0)),
                      static_cast<float>(motion.dot(tool_force_)), static_cast<float>(displacement),
                      static_cast<float>(at_velocity), proto::kOneStep});
  }
}

void ContactResponse::find_turning(const bodies::World& world, const MechanicalSystem& system,
                                   double step_s) {
  for (const Group& group : groups_) {
    const int rigid = touches_[group.first].sphere->rigid;
    if (rigid < 0 || turning_.size() == proto::kMaxTurningBodies) continue;
    const bodies::RigidBody& body = world.rigid_bodies[static_cast<std::size_t>(rigid)];
    const Eigen::Vector3f centre_m = body.position_m.cast<float>();
    const Eigen::Vector3f velocity_m_s =
        ((system.trial().rigid_bodies[static_cast<std::size_t>(rigid)].position_m -
          body.position_m) /
         step_s)
            .cast<float>();
    proto::TurningBody& turning = turning_.emplace_back();
    turning = {};
    turning.body = static_cast<std::uint32_t>(touches_[group.first].sphere->body);
    turning.centre_m = {centre_m.x(), centre_m.y(), centre_m.z()};
    turning.velocity_m_s = {velocity_m_s.x(), velocity_m_s.y(), velocity_m_s.z()};
    for (std::size_t mode = 0; mode < modes_.size(); ++mode) {
      const Eigen::Vector3f turn = motions_[mode].segment<3>(body.unknown + 3).cast<float>();
      turning.turns[mode] = {turn.x(), turn.y(), turn.z()};
    }
  }
}

void ContactResponse::find(const bodies::World& world, const MechanicalSystem& system,
                           ImplicitStage& stage, double step_s, std::span<const ToolTouch> touches,
                           const Eigen::VectorXd& velocity, const Budget& budget) {
  clear();
  group(touches);
  tool_force_.setZero(system.size());
  for (const ToolTouch& touch : touches)
    system.push_sphere(*touch.sphere, touch.force_N, touch.couple_N_m, tool_force_);
  find_pushes(system);
  answer_pushes(stage, budget);
  if (answer_count_ == 0) return;
  find_modes(system, stage, step_s, velocity);
  find_turning(world, system, step_s);
}

/// Over half the step dampers resist half as much, springs a quarter.
void ContactResponse::find_damping(MechanicalSystem& system, double step_s) {
  system.linearise(JacobianKind::kDefinite, 0.5 * step_s);
  Eigen::VectorXd resisted(system.size());
  for (std::size_t mode = 0; mode < modes_.size(); ++mode) {
    system.multiply(motions_[mode], resisted);
    const double half = motions_[mode].dot(resisted) / (step_s * step_s);
    const double inertia = modes_[mode].inertia_share;
    modes_[mode].damping_share =
        static_cast<float>(std::clamp(4.0 * half - 3.0 * inertia - 1.0, 0.0, 1.0 - inertia));
  }
}

proto::SphereResponse ContactResponse::response_of(const MechanicalSystem& system,
                                                   const bodies::SphereBinding& sphere) const {
  proto::SphereResponse response{};
  for (std::size_t mode = 0; mode < modes_.size(); ++mode) {
    const Eigen::Vector3f part = system.velocity_of(sphere, motions_[mode]).cast<float>();
    response.modes[mode] = {part.x(), part.y(), part.z()};
  }
  return response;
}

proto::SphereResponse ContactResponse::turning_of(const bodies::RigidBody& body) const {
  proto::SphereResponse response{};
  for (std::size_t mode = 0; mode < modes_.size(); ++mode) {
    const Eigen::Vector3f part = motions_[mode].segment<3>(body.unknown + 3).cast<float>();
    response.modes[mode] = {part.x(), part.y(), part.z()};
  }
  return response;
}

}  // namespace stillgrid::dynamics
