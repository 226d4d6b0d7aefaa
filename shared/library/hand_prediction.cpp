#include <Eigen/Eigenvalues>
#include <algorithm>

#include "shared/library/hand_pushes.hpp"
#include "shared/library/vectors.hpp"

namespace stillgrid::library {

namespace {

using Eigen::Vector3d;

/// Of a push: what else acts on the body opposed the rest of it in the last step, and will.
double share_not_resisted(const Eigen::Ref<const Eigen::VectorXd>& change,
                          const Eigen::Ref<const Eigen::VectorXd>& push) {
  const double size = push.squaredNorm();
  return size > 0.0 ? 1.0 - std::clamp((push - change).dot(push) / size, 0.0, 1.0) : 1.0;
}

}  // namespace

template <class Velocity>
void HandPushes::fit(const Chosen& chosen, double step_s, publication::MovingRecords& moving,
                     Velocity&& velocity, Modes& displacements) const {
  using Gram = Eigen::Matrix<double, 6, 6>;
  const int count = chosen.body->count();
  Gram gram = Gram::Zero();
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
  const Eigen::SelfAdjointEigenSolver<Gram> solved(gram);
  const double least = 1e-6 * solved.eigenvalues().maxCoeff();
  Twist found = Twist::Zero();
  for (int i = 0; i < 6; ++i)
    if (solved.eigenvalues()[i] > least)
      found += solved.eigenvectors().col(i).dot(moment) / solved.eigenvalues()[i] *
               solved.eigenvectors().col(i);
  for (int mode = 0; mode < count; ++mode) displacements[chosen.first + mode] = found[mode];
}

void HandPushes::lead(publication::MovingRecords& moving, double step_s, bool is_tried) {
  const auto records = moving.records();
  const auto newest = [&](std::uint32_t i) { return vector(records[i].newest.velocity_m_s); };
  const auto older = [&](std::uint32_t i) { return vector(records[i].older[0].velocity_m_s); };
  const auto tried = [&](std::uint32_t i) { return vector(records[i].predicted_velocity_m_s); };
  Modes before = Modes::Zero();
  now_ = held_ = led_ = before;
  is_tried_ = is_tried;
  for (const Chosen& chosen : chosen_) {
    fit(chosen, step_s, moving, newest, now_);
    fit(chosen, step_s, moving, older, before);
    Modes change = now_ - before;
    const Twist wrench = chosen.body->wrench_of(before_);
    const auto own = [&](Modes& modes) {
      return modes.segment(chosen.first, chosen.body->count());
    };
    for (int mode = 0; mode < chosen.body->count(); ++mode)
      held_[chosen.first + mode] = chosen.body->motion(mode).dot(wrench);
    if (is_tried)
      fit(chosen, step_s, moving, tried, led_);
    else
      own(led_) = own(now_) + share_not_resisted(own(change), own(held_)) * own(held_);
  }
  if (!is_tried) add_to_predicted(moving, step_s, led_ - now_);
}

/// How the chosen body goes on: `now` at its velocity, `whole` in the step.
void HandPushes::add_modes(const Chosen& chosen, double step_s, const Modes& now,
                           const Modes& whole, const Modes& push) {
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

/// The spheres of all chosen bodies go where these displacements lead beside their prediction.
void HandPushes::add_to_predicted(publication::MovingRecords& moving, double step_s,
                                  const Modes& displacements) const {
  if (chosen_.empty()) return;
  for (proto::SphereRecord& record : moving.records()) {
    const Chosen* chosen = chosen_of(record.body);
    if (chosen == nullptr) continue;
    Vector3d velocity_m_s = vector(record.predicted_velocity_m_s);
    for (int mode = 0; mode < chosen->body->count(); ++mode)
      velocity_m_s += displacements[chosen->first + mode] / step_s *
                      chosen->body->motion_at(mode, vector(record.newest.position_m));
    record.predicted_velocity_m_s = floats(velocity_m_s);
  }
}

publication::SnapshotPrediction HandPushes::predict(publication::MovingRecords& moving,
                                                    double step_s,
                                                    std::span<const double> predicted) {
  const auto records = moving.records();
  if (!predicted.empty()) moving.predict(predicted);
  const auto led = [&](std::uint32_t i) { return vector(records[i].predicted_velocity_m_s); };
  modes_.clear();
  turning_.clear();
  Modes whole = Modes::Zero(), push = whole;
  for (const Chosen& chosen : chosen_) {
    const Twist wrench = chosen.body->wrench_of(pushes_);
    for (int mode = 0; mode < chosen.body->count(); ++mode)
      push[chosen.first + mode] = chosen.body->motion(mode).dot(wrench);
  }
  whole = led_ + push - held_;
  for (const Chosen& chosen : chosen_) {
    if (!predicted.empty()) fit(chosen, step_s, moving, led, whole);
    add_modes(chosen, step_s, now_, whole, push);
  }
  if (predicted.empty())
    add_to_predicted(moving, step_s, is_tried_ ? Modes(push - held_) : Modes(whole - now_));
  for (std::size_t i = 0; i < responding_.size(); ++i)
    records[responding_[i]].response = static_cast<std::uint32_t>(i + 1);
  return {.period_ns = static_cast<std::uint64_t>(step_s * 1e9 + 0.5),
          .modes = modes_,
          .turning = turning_,
          .responses = responses_};
}

}  // namespace stillgrid::library
