#include "shared/local/given_bodies.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "proto/segment_header.hpp"
#include "shared/dynamics/engine.hpp"
#include "shared/dynamics/rigid_motion.hpp"

namespace stillgrid::local {
namespace {

using dynamics::kTick_s;
using Eigen::Vector3d;

/// Motion of a point beside the centre, by the twist.
using PointMotion = Eigen::Matrix<double, 3, 6>;
PointMotion motion_of(const Vector3d& arm_m) noexcept {
  PointMotion motion;
  motion.leftCols<3>().setIdentity();
  motion.rightCols<3>() << 0.0, arm_m.z(), -arm_m.y(), -arm_m.z(), 0.0, arm_m.x(), arm_m.y(),
      -arm_m.x(), 0.0;
  return motion;
}

Matrix6 turned(const Matrix6& matrix, const Eigen::Quaterniond& turn) noexcept {
  const Eigen::Matrix3d axes = turn.toRotationMatrix();
  Matrix6 out;
  for (int i = 0; i < 6; i += 3)
    for (int j = 0; j < 6; j += 3)
      out.block<3, 3>(i, j) = axes * matrix.block<3, 3>(i, j) * axes.transpose();
  return out;
}

}  // namespace

GivenBodies::GivenBodies(GivenModel model)
    : model_(std::move(model)),
      tools_(model_),
      contacts_(model_.tools.size()),
      pushes_(model_.tools.size() * kMaxHeldBodies) {
  state_.bodies.reserve(kMaxHeldBodies);
  state_.spheres.reserve(kMaxGivenSpheres);
  turns_.reserve(kMaxHeldBodies);
  starts_.reserve(kMaxHeldBodies);
  led_.reserve(kMaxGivenSpheres);
  led_bodies_.reserve(kMaxHeldBodies);
  pushed_.reserve(GivenTools::kMaxContacts);
}

void GivenBodies::begin(const GivenState& state,
                        std::span<const std::optional<dynamics::ToolPose>> tools) noexcept {
  state_.bodies.assign(state.bodies.begin(), state.bodies.end());
  state_.spheres.assign(state.spheres.begin(), state.spheres.end());
  turns_.assign(state.bodies.size(), Eigen::Quaterniond::Identity());
  starts_.clear();
  for (const GivenBody& body : state.bodies) starts_.push_back(body.twist);
  ticks_ = 0;
  tools_.begin(state);
  if (!tools.empty()) tools_.place(tools);
  for (std::size_t hand = 0; hand < contacts_.size(); ++hand)
    std::fill_n(pushes_.begin() + static_cast<std::ptrdiff_t>(hand * kMaxHeldBodies),
                state.bodies.size(), Push());
}

Vector3d GivenBodies::position_m(const GivenSphere& sphere) const noexcept {
  return state_.bodies[sphere.body].centre_m + turns_[sphere.body] * sphere.arm_m;
}

Vector3d GivenBodies::velocity_m_s(const GivenSphere& sphere,
                                   const Vector3d& point_m) const noexcept {
  const GivenBody& body = state_.bodies[sphere.body];
  return motion_of(point_m - body.centre_m) * body.twist + sphere.own_m_s;
}

bool GivenBodies::is_plausible() const noexcept {
  return std::ranges::all_of(state_.bodies, [](const GivenBody& body) {
    // Written so that a NaN does not pass.
    return body.centre_m.cwiseAbs().maxCoeff() <= proto::kLargestNumber &&
           body.twist.cwiseAbs().maxCoeff() <= proto::kLargestNumber && !body.centre_m.hasNaN() &&
           !body.twist.hasNaN();
  });
}

void GivenBodies::stand() noexcept {
  for (GivenBody& body : state_.bodies) {
    body.twist.setZero();
    body.acceleration.setZero();
    body.inverse_inertia.setZero();
  }
}

void GivenBodies::add_push(std::size_t hand, std::size_t body, const Twist& wrench) noexcept {
  const Contacts& contacts = contacts_[hand];
  Push& push = pushes_[hand * kMaxHeldBodies + body];
  push.wrench += kTick_s * wrench;
  push.weight_N += contacts.weight_N;
  push.weighted += contacts.weighted;
  push.contacts = std::max(push.contacts, contacts.count);
  push.work_J += kTick_s * (wrench.dot(state_.bodies[body].twist) + contacts.own_W);
}

/// What resists a body's push keeps it to its course: a damper on what leaves it, along the push.
/// Without it a light body would swing between a stiff tool and a steady force.
GivenBodies::Course GivenBodies::course_of(std::size_t index, const Matrix6& inverse_inertia,
                                           const Matrix6& resisting) const noexcept {
  const GivenBody& body = state_.bodies[index];
  Course course{body.twist, inverse_inertia};
  const Twist led = inverse_inertia * body.push;
  const double power = body.push.dot(led);
  if (!(power > 0.0 && body.resisted > 0.0)) return course;
  // Critical for a mass of its own on the contact's spring.
  const double damping = 2.0 * body.resisted * std::sqrt((inverse_inertia * resisting).trace());
  const double share = damping / (1.0 + damping) / power;
  const Twist kept =
      starts_[index] + static_cast<double>(ticks_) * kTick_s * (body.acceleration + led);
  course.twist -= share * body.push.dot(body.twist - kept) * led;
  course.inverse_inertia -= share * led * led.transpose();
  return course;
}

void GivenBodies::move(std::size_t index) noexcept {
  GivenBody& body = state_.bodies[index];
  const LedBody& led = led_bodies_[index];
  body.centre_m = led.start_m + kTick_s * body.twist.head<3>();
  turns_[index] =
      (dynamics::rotation_by(kTick_s * body.twist.tail<3>()) * led.start_turn).normalized();
}

/// Moves all bodies to where they go in a tick without the tools.
void GivenBodies::lead() noexcept {
  led_.resize(state_.spheres.size());
  led_bodies_.clear();
  for (std::size_t i = 0; i < led_.size(); ++i) {
    led_[i].moved_m = -position_m(state_.spheres[i]);
    state_.spheres[i].arm_m += kTick_s * state_.spheres[i].own_m_s;
  }
  for (std::size_t index = 0; index < state_.bodies.size(); ++index) {
    GivenBody& body = state_.bodies[index];
    body.twist += kTick_s * body.acceleration;
    led_bodies_.push_back({body.centre_m, turns_[index], body.twist});
    move(index);
  }
  for (std::size_t i = 0; i < led_.size(); ++i) {
    led_[i].end_m = position_m(state_.spheres[i]);
    led_[i].moved_m += led_[i].end_m;
  }
}

/// Moves a body under its contacts.
void GivenBodies::push(std::size_t index, std::span<const GivenContact> contacts) noexcept {
  GivenBody& body = state_.bodies[index];
  for (Contacts& of_hand : contacts_) of_hand = {};
  Contacts all;
  for (const GivenContact& contact : contacts) {
    const GivenSphere& sphere = state_.spheres[contact.sphere];
    if (sphere.body != index) continue;
    const Vector3d arm_m = contact.point_m - body.centre_m;
    const PointMotion motion = motion_of(arm_m);
    const double size_N = contact.force_N.norm();
    Contacts& of_hand = contacts_[contact.hand];
    of_hand.wrench += motion.transpose() * contact.force_N;
    of_hand.resisting += motion.transpose() * contact.resisting_kg * motion;
    of_hand.weight_N += size_N;
    of_hand.weighted += size_N * arm_m;
    of_hand.own_W += contact.force_N.dot(sphere.own_m_s);
    ++of_hand.count;
  }
  for (const Contacts& of_hand : contacts_) {
    all.wrench += of_hand.wrench;
    all.resisting += of_hand.resisting;
    all.count += of_hand.count;
  }
  if (all.count == 0) return;
  const Course course =
      course_of(index, turned(body.inverse_inertia, turns_[index]), all.resisting);
  const Twist led = body.twist;
  const Matrix6 equations = Matrix6::Identity() + all.resisting * course.inverse_inertia;
  const Twist wrench =
      equations.partialPivLu().solve(all.wrench - all.resisting * (course.twist - led) / kTick_s);
  body.twist = course.twist + kTick_s * course.inverse_inertia * wrench;
  move(index);
  for (std::size_t hand = 0; hand < contacts_.size(); ++hand)
    if (contacts_[hand].count > 0)
      add_push(hand, index,
               contacts_[hand].wrench - contacts_[hand].resisting * (body.twist - led) / kTick_s);
}

void GivenBodies::step(std::span<const std::optional<dynamics::ToolPose>> tools) noexcept {
  tools_.place(tools);
  ++ticks_;
  lead();
  const std::span<const GivenContact> contacts = tools_.touch(state_.bodies, state_.spheres, led_);
  if (contacts.empty()) return tools_.settle(state_.bodies, state_.spheres, {});
  pushed_.clear();
  for (const GivenContact& contact : contacts)
    pushed_.push_back(
        {contact.point_m - state_.bodies[state_.spheres[contact.sphere].body].centre_m,
         Vector3d::Zero()});
  for (std::size_t index = 0; index < state_.bodies.size(); ++index) push(index, contacts);
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const GivenSphere& sphere = state_.spheres[contacts[c].sphere];
    const Twist aside = state_.bodies[sphere.body].twist - led_bodies_[sphere.body].twist;
    pushed_[c].aside_m = kTick_s * (motion_of(pushed_[c].aside_m) * aside);
    pushed_[c].end_m = position_m(sphere);
  }
  tools_.settle(state_.bodies, state_.spheres, pushed_);
}

}  // namespace stillgrid::local
