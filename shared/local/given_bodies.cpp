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
      tools_(model_.tools.size()),
      contacts_(model_.tools.size()),
      pushes_(model_.tools.size() * kMaxHeldBodies) {
  state_.bodies.reserve(kMaxHeldBodies);
  state_.spheres.reserve(kMaxGivenSpheres);
  turns_.reserve(kMaxHeldBodies);
  starts_.reserve(kMaxHeldBodies);
  for (std::size_t hand = 0; hand < tools_.size(); ++hand) {
    double& radius_m = radius_m_.emplace_back(0.0);
    for (const GivenModel::ToolSphere& sphere : model_.tools[hand].spheres)
      radius_m = std::max(radius_m, sphere.centre_m.norm() + sphere.radius_m);
    tools_[hand].centre_m.resize(model_.tools[hand].spheres.size());
  }
}

void GivenBodies::begin(const GivenState& state) noexcept {
  state_.bodies.assign(state.bodies.begin(), state.bodies.end());
  state_.spheres.assign(state.spheres.begin(), state.spheres.end());
  turns_.assign(state.bodies.size(), Eigen::Quaterniond::Identity());
  starts_.clear();
  for (const GivenBody& body : state.bodies) starts_.push_back(body.twist);
  ticks_ = 0;
  for (PlacedTool& tool : tools_) tool.is_here = false;
  for (std::size_t hand = 0; hand < tools_.size(); ++hand)
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
  for (GivenBody& body : state_.bodies) body.twist.setZero();
}

void GivenBodies::place(std::span<const std::optional<dynamics::ToolPose>> tools) noexcept {
  for (std::size_t hand = 0; hand < tools_.size(); ++hand) {
    PlacedTool& tool = tools_[hand];
    const bool was_here = std::exchange(tool.is_here, hand < tools.size() && tools[hand]);
    if (!tool.is_here) continue;
    const Eigen::Quaterniond before = tool.pose.orientation;
    tool.pose = *tools[hand];
    tool.turning_rad_s.setZero();
    if (was_here)
      tool.turning_rad_s =
          dynamics::rotation_vector(tool.pose.orientation * before.conjugate()) / kTick_s;
    for (std::size_t i = 0; i < tool.centre_m.size(); ++i)
      tool.centre_m[i] =
          tool.pose.position_m + tool.pose.orientation * model_.tools[hand].spheres[i].centre_m;
  }
}

/// Adds what a tool does to a sphere of a body that stands at arm_m beside the body's centre.
void GivenBodies::touch(std::size_t hand, const GivenBody& body, const Vector3d& arm_m,
                        const GivenSphere& sphere, Contacts& contacts) const noexcept {
  const PlacedTool& tool = tools_[hand];
  const Vector3d sphere_m = body.centre_m + arm_m;
  const double near_m = radius_m_[hand] + sphere.radius_m;
  if (!((sphere_m - tool.pose.position_m).squaredNorm() < near_m * near_m)) return;
  const GivenModel::Tool& shape = model_.tools[hand];
  for (std::size_t i = 0; i < shape.spheres.size(); ++i) {
    const Vector3d apart_m = tool.centre_m[i] - sphere_m;
    const double touching_m = shape.spheres[i].radius_m + sphere.radius_m;
    const double distance_m = apart_m.norm();
    if (!(distance_m < touching_m)) continue;
    const collision::ContactMaterial material =
        collision::tool_material(model_.materials[sphere.material], shape.slip_speed_m_s);
    const Vector3d normal =
        distance_m > 1e-12 ? Vector3d(apart_m / distance_m) : Vector3d(Vector3d::UnitZ());
    const Vector3d point_m =
        tool.centre_m[i] - shape.spheres[i].radius_m / touching_m * distance_m * normal;
    const PointMotion motion = motion_of(point_m - body.centre_m);
    const Vector3d passing_m_s = tool.pose.velocity_m_s +
                                 tool.turning_rad_s.cross(point_m - tool.pose.position_m) -
                                 motion * body.twist - sphere.own_m_s;
    const Vector3d force_N =
        -collision::contact_force_N(material, touching_m - distance_m, normal, passing_m_s);
    const double apart_m_s = normal.dot(passing_m_s);
    const double slip_m_s = (passing_m_s - apart_m_s * normal).norm();
    const double rubbing =  // N s/m, of friction
        material.friction * std::max(0.0, -normal.dot(force_N)) /
        std::max(slip_m_s, material.slip_speed_m_s);
    const double across = kTick_s * rubbing;
    const double along = kTick_s * (kTick_s * material.stiffness_N_per_m +
                                    (apart_m_s < 0.0 ? material.damping_N_s_per_m : 0.0));
    const Eigen::Matrix3d resisting =
        across * Eigen::Matrix3d::Identity() + (along - across) * normal * normal.transpose();
    contacts.wrench += motion.transpose() * force_N;
    contacts.resisting += motion.transpose() * resisting * motion;
    const double size_N = force_N.norm();
    contacts.weight_N += size_N;
    contacts.weighted += size_N * (point_m - body.centre_m);
    contacts.own_W += force_N.dot(sphere.own_m_s);
    ++contacts.count;
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

void GivenBodies::step(std::size_t index, std::span<GivenSphere> spheres) noexcept {
  GivenBody& body = state_.bodies[index];
  Eigen::Quaterniond& turn = turns_[index];
  const Vector3d start_m = body.centre_m;
  const Eigen::Quaterniond start = turn;
  body.twist += kTick_s * body.acceleration;
  const auto move = [&] {
    body.centre_m = start_m + kTick_s * body.twist.head<3>();
    turn = (dynamics::rotation_by(kTick_s * body.twist.tail<3>()) * start).normalized();
  };
  move();  // where the body goes without the tools
  for (Contacts& contacts : contacts_) contacts = {};
  for (GivenSphere& sphere : spheres) {
    sphere.arm_m += kTick_s * sphere.own_m_s;
    const Vector3d arm_m = turn * sphere.arm_m;
    for (std::size_t hand = 0; hand < tools_.size(); ++hand)
      if (tools_[hand].is_here) touch(hand, body, arm_m, sphere, contacts_[hand]);
  }
  Contacts all;
  for (const Contacts& contacts : contacts_) {
    all.wrench += contacts.wrench;
    all.resisting += contacts.resisting;
    all.count += contacts.count;
  }
  if (all.count == 0) return;
  const Course course = course_of(index, turned(body.inverse_inertia, turn), all.resisting);
  const Twist led = body.twist;
  const Matrix6 equations = Matrix6::Identity() + all.resisting * course.inverse_inertia;
  const Twist wrench =
      equations.partialPivLu().solve(all.wrench - all.resisting * (course.twist - led) / kTick_s);
  body.twist = course.twist + kTick_s * course.inverse_inertia * wrench;
  move();
  for (std::size_t hand = 0; hand < tools_.size(); ++hand)
    if (contacts_[hand].count > 0)
      add_push(hand, index,
               contacts_[hand].wrench - contacts_[hand].resisting * (body.twist - led) / kTick_s);
}

void GivenBodies::step(std::span<const std::optional<dynamics::ToolPose>> tools) noexcept {
  place(tools);
  ++ticks_;
  const std::span<GivenSphere> all(state_.spheres);
  for (std::size_t body = 0, first = 0; body < state_.bodies.size(); ++body) {
    std::size_t end = first;
    while (end < all.size() && all[end].body == body) ++end;
    step(body, all.subspan(first, end - first));
    first = end;
  }
}

}  // namespace stillgrid::local
