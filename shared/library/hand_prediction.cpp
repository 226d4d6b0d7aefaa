#include <Eigen/Eigenvalues>
#include <algorithm>

#include "shared/library/hand_pushes.hpp"
#include "shared/library/vectors.hpp"

namespace stillgrid::library {
namespace {

using Eigen::Vector3d;

}  // namespace

template <class Velocity>
void HandPushes::fit(const Chosen& chosen, double step_s, MovingRecords& moving,
                     Velocity&& velocity, Modes& displacements) const {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  const int count = chosen.body->count();
  Matrix6 gram = Matrix6::Zero();
  Twist moment = Twist::Zero();
  const auto records = moving.records();
  for (std::size_t i = 0; i < responding_.size(); ++i) {
    if (records[responding_[i]].body != chosen.body->body()) continue;
    Eigen::Matrix<double, 3, 6> parts = Eigen::Matrix<double, 3, 6>::Zero();
    for (int mode = 0; mode < count; ++mode)
      parts.col(mode) = vector(responses_[i].modes[static_cast<std::size_t>(chosen.first + mode)]);
    gram += parts.transpose() * parts;
    moment += parts.transpose() * (step_s * velocity(responding_[i]));
  }
  // What no near sphere shows, as the turning of a ball, is none of the motion.
  const Eigen::SelfAdjointEigenSolver<Matrix6> solved(gram);
  const double least = 1e-6 * solved.eigenvalues().maxCoeff();
  Twist found = Twist::Zero();
  for (int i = 0; i < 6; ++i)
    if (solved.eigenvalues()[i] > least)
      found += solved.eigenvectors().col(i).dot(moment) / solved.eigenvalues()[i] *
               solved.eigenvectors().col(i);
  for (int mode = 0; mode < count; ++mode) displacements[chosen.first + mode] = found[mode];
}

/// Of the push: what else acts on the body opposed the rest of it in the last step, and will.
double HandPushes::share_not_resisted(const Chosen& chosen, const Modes& now, const Modes& before,
                                      const Modes& push) const {
  const Twist wrench = chosen.body->wrench_of(before_);
  double resisted = 0.0, size = 0.0;
  for (int mode = 0; mode < chosen.body->count(); ++mode) {
    const int at = chosen.first + mode;
    const double others = now[at] - before[at] - chosen.body->motion(mode).dot(wrench);
    resisted -= others * push[at];
    size += push[at] * push[at];
  }
  return size > 0.0 ? 1.0 - std::clamp(resisted / size, 0.0, 1.0) : 1.0;
}

publication::SnapshotPrediction HandPushes::predict(MovingRecords& moving, double step_s,
                                                    std::span<const double> predicted) {
  const auto records = moving.records();
  for (std::size_t i = 0; i < predicted.size() / 3; ++i)
    records[i].predicted_velocity_m_s = floats(Vector3d(predicted.data() + 3 * i));
  modes_.clear();
  turning_.clear();
  Modes now = Modes::Zero(), before = now, whole = now, push = now;
  for (const Chosen& chosen : chosen_) {
    fit(
        chosen, step_s, moving,
        [&](std::uint32_t i) { return vector(records[i].newest.velocity_m_s); }, now);
    fit(
        chosen, step_s, moving,
        [&](std::uint32_t i) { return vector(records[i].older[0].velocity_m_s); }, before);
    const Twist wrench = chosen.body->wrench_of(pushes_);
    for (int mode = 0; mode < chosen.body->count(); ++mode)
      push[chosen.first + mode] = chosen.body->motion(mode).dot(wrench);
    if (predicted.empty()) {
      const double share = share_not_resisted(chosen, now, before, push);
      for (int at = chosen.first; at < chosen.first + chosen.body->count(); ++at)
        whole[at] = now[at] + share * push[at];
    } else {
      fit(
          chosen, step_s, moving,
          [&](std::uint32_t i) { return vector(records[i].predicted_velocity_m_s); }, whole);
    }
    Vector3d velocity_m_s = Vector3d::Zero();
    proto::TurningBody turning{};
    for (int mode = 0; mode < chosen.body->count(); ++mode) {
      const int at = chosen.first + mode;
      const Twist motion = chosen.body->motion(mode);
      velocity_m_s += whole[at] / step_s * motion.head<3>();
      turning.turns[static_cast<std::size_t>(at)] = floats(motion.tail<3>());
      modes_.push_back({1.0F, static_cast<float>(push[at]), static_cast<float>(whole[at]),
                        static_cast<float>(now[at]), proto::kOneStep});
    }
    turning.body = chosen.body->body();
    turning.centre_m = floats(chosen.body->centre_m());
    turning.velocity_m_s = floats(velocity_m_s);
    if (turning_.size() < proto::kMaxTurningBodies) turning_.push_back(turning);
  }
  if (predicted.empty() && !chosen_.empty()) {
    for (proto::SphereRecord& record : records) {
      const Chosen* chosen = chosen_of(record.body);
      if (chosen == nullptr) continue;
      Vector3d velocity_m_s = vector(record.newest.velocity_m_s);
      for (int mode = 0; mode < chosen->body->count(); ++mode)
        velocity_m_s += (whole[chosen->first + mode] - now[chosen->first + mode]) / step_s *
                        chosen->body->motion_at(mode, vector(record.newest.position_m));
      record.predicted_velocity_m_s = floats(velocity_m_s);
    }
  }
  for (std::size_t i = 0; i < responding_.size(); ++i)
    records[responding_[i]].response = static_cast<std::uint32_t>(i + 1);
  return {.period_ns = static_cast<std::uint64_t>(step_s * 1e9 + 0.5),
          .modes = modes_,
          .turning = turning_,
          .responses = responses_};
}

}  // namespace stillgrid::library
