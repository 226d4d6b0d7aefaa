#include "sim_server/dynamics/step/prediction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "sim_server/contact/field_touch.hpp"
#include "sim_server/dynamics/forces/implicit_stage.hpp"

namespace stillgrid::dynamics {
namespace {

/// Of a step, that looking ahead may take of real time: the age of a snapshot is what costs
/// stability.
constexpr double kMaxShare = 0.1;
/// Of the predicted velocity: the next snapshot corrects what it leaves.
constexpr double kTolerance_m_s = 1e-6;
constexpr int kMaxIterations = 3;
/// Of the residual, that the last iteration leaves at most.
constexpr double kProgress = 0.9;
/// Likewise, that linear equations leave of it.
constexpr double kAccuracy = 1e-3;

contact::SideMotion side_of(const bodies::World& world, int sphere) {
  const bodies::SphereBinding& binding = world.spheres[static_cast<std::size_t>(sphere)];
  const bodies::SphereMotion motion = bodies::sphere_motion(world, binding);
  contact::SideMotion side{motion.position_m, motion.velocity_m_s};
  if (binding.rigid >= 0)
    side.spin_rad_s =
        world.rigid_bodies[static_cast<std::size_t>(binding.rigid)].angular_velocity_rad_s;
  return side;
}

/// A contact where the world is now.
struct Met {
  contact::Contact contact;  // as stiff as it is there
  contact::ContactMotion motion;
  double depth_m;
  std::optional<bodies::SphereBinding> field = {};  // the sphere that a field is
};

Met met_at(const bodies::World& world, const contact::Contact& contact) {
  const bool is_first = bodies::is_field(world, contact.a);
  const bool is_of_field = is_first || (contact.b >= 0 && bodies::is_field(world, contact.b));
  const contact::SideMotion other = is_first || (!is_of_field && contact.b < 0)
                                        ? contact::kinematic_side(contact)
                                        : side_of(world, is_of_field ? contact.a : contact.b);
  if (!is_of_field) {
    const contact::ContactMotion motion =
        contact::relative_motion(contact, side_of(world, contact.a), other);
    return {contact, motion, contact::contact_depth_m(contact, motion.position_m)};
  }
  const bodies::FieldBody& field = bodies::field_of(world, is_first ? contact.a : contact.b);
  const contact::FieldPose pose = contact::pose_of(field, world.rigid_bodies);
  const contact::FieldTouch touch = contact::touch_of(
      field, pose, other.position_m, is_first ? contact.radius_b_m : contact.radius_a_m);
  bodies::SphereBinding binding;
  binding.body = field.body;
  binding.material = field.material;
  binding.radius_m = contact::tangent_radius_m(field);
  binding.rigid = field.rigid;
  binding.local_m = pose.into(touch.centre_m);
  contact::SideMotion own{touch.centre_m, Eigen::Vector3d::Zero()};
  if (field.rigid >= 0) {
    own.velocity_m_s = bodies::sphere_motion(world, binding).velocity_m_s;
    own.spin_rad_s =
        world.rigid_bodies[static_cast<std::size_t>(field.rigid)].angular_velocity_rad_s;
  }
  return {contact::scaled(contact, touch),
          contact::relative_motion(contact, is_first ? own : other, is_first ? other : own),
          touch.depth_m, binding};
}

/// The next step under a force of the tool that stays as it is.
class PushedStage final : public ImplicitStage {
 public:
  PushedStage(MechanicalSystem& system, double step_s) : ImplicitStage(system, step_s) {}
  void push(const Eigen::VectorXd& momentum) { push_ = &momentum; }
  void residual(const Eigen::VectorXd& u, Eigen::VectorXd& residual) override {
    ImplicitStage::residual(u, residual);
    residual -= *push_;
  }

 private:
  const Eigen::VectorXd* push_ = nullptr;
};

bool is_kinematic(const bodies::World& world, const bodies::SphereBinding& sphere) {
  return sphere.rigid >= 0 &&
         world.rigid_bodies[static_cast<std::size_t>(sphere.rigid)].unknown == bodies::kNoUnknown;
}

}  // namespace

Prediction::Prediction(bool is_explicit) : is_explicit_(is_explicit), solver_(kTolerance_m_s) {}

void Prediction::take_contacts(const bodies::World& world,
                               std::span<const contact::Contact> contacts,
                               std::span<const ContactMemory> kept, double step_s) {
  near_.clear();
  for (const contact::Contact& contact : contacts) {
    const auto [own, motion, depth_m, field] = met_at(world, contact);
    if (depth_m + step_s * motion.velocity_m_s.norm() < 0.0) continue;
    contact::Contact& near = near_.emplace_back(contact);
    near.depth_before_m = depth_m;
    near.start_b_m = contact.position_b_m;
    if (contact.is_tool) near.position_b_m += step_s * contact.velocity_b_m_s;
  }
  find_stretches(kept, near_, stretches_m_);
  system_.take(world, near_, stretches_m_, Levers::kMean);
}

void Prediction::take_tool(const bodies::World& world, std::span<const contact::Contact> contacts) {
  tool_force_.setZero(system_.size());
  touches_.clear();
  field_spheres_.clear();
  field_spheres_.reserve(contacts.size());  // which touches point into
  for (const contact::Contact& contact : contacts) {
    const auto [own, motion, depth_m, field] = met_at(world, contact);
    if (field) field_spheres_.push_back(*field);
    const bodies::SphereBinding& sphere =
        field ? field_spheres_.back() : world.spheres[static_cast<std::size_t>(contact.a)];
    if (is_kinematic(world, sphere)) continue;
    const contact::ContactForce law = contact::contact_force(own, motion, 0.0, nullptr);
    ToolTouch& touch = touches_.emplace_back();
    touch = {&sphere, depth_m, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    if (!law.touching) continue;
    touch.force_N = law.force_N;
    touch.couple_N_m = -contact::contact_shares(contact).a * law.arm_m.cross(law.friction_N);
    system_.push_sphere(sphere, touch.force_N, touch.couple_N_m, tool_force_);
  }
}

/// The spheres nearest to the tool, as many as a snapshot has room for.
void Prediction::take_responses(const bodies::World& world,
                                std::span<const contact::Contact> tool) {
  near_tool_.clear();
  for (std::size_t i = 0; i < world.spheres.size(); ++i) {
    const bodies::SphereBinding& sphere = world.spheres[i];
    if (sphere.is_field_point || is_kinematic(world, sphere)) continue;
    const Eigen::Vector3d at_m = bodies::sphere_motion(world, sphere).position_m;
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const contact::Contact& contact : tool)
      nearest_m = std::min(
          nearest_m, (at_m - contact.position_b_m).norm() - contact.radius_b_m - sphere.radius_m);
    near_tool_.emplace_back(nearest_m, i);
  }
  const std::size_t most = std::min<std::size_t>(proto::kMaxResponses, near_tool_.size());
  std::nth_element(near_tool_.begin(), near_tool_.begin() + static_cast<std::ptrdiff_t>(most),
                   near_tool_.end());
  near_tool_.resize(most);
  for (const auto& [distance_m, i] : near_tool_) {
    const proto::SphereResponse response = response_.response_of(system_, world.spheres[i]);
    if (response.modes == decltype(response.modes){}) continue;
    responses_.push_back(response);
    spheres_[i].response = static_cast<std::uint32_t>(responses_.size());
  }
}

/// How each frame that may give way moves in the modes: its origin, then how it turns.
void Prediction::take_field_responses(const bodies::World& world) {
  for (std::size_t i = 0; i < world.fields.size(); ++i) {
    bodies::SphereBinding origin;
    origin.rigid = world.fields[i].rigid;
    if (origin.rigid < 0 || is_kinematic(world, origin)) continue;
    const proto::SphereResponse moves = response_.response_of(system_, origin);
    const proto::SphereResponse turns =
        response_.turning_of(world.rigid_bodies[static_cast<std::size_t>(origin.rigid)]);
    if (moves.modes == decltype(moves.modes){} && turns.modes == decltype(turns.modes){}) continue;
    responses_.push_back(moves);
    fields_[i].response = static_cast<std::uint32_t>(responses_.size());
    responses_.push_back(turns);
  }
}

/// As they move now.
void Prediction::move_fields_on(const bodies::World& world) {
  fields_.assign(world.fields.size(), {});
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    if (world.fields[i].rigid < 0) continue;
    const bodies::RigidBody& body =
        world.rigid_bodies[static_cast<std::size_t>(world.fields[i].rigid)];
    fields_[i] = {body.velocity_m_s, body.angular_velocity_rad_s};
  }
}

/// To where the system is placed.
void Prediction::predict_fields(const bodies::World& world, double step_s) {
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    if (world.fields[i].rigid < 0) continue;
    const auto rigid = static_cast<std::size_t>(world.fields[i].rigid);
    const bodies::RigidBody &from = world.rigid_bodies[rigid],
                            &to = system_.trial().rigid_bodies[rigid];
    fields_[i].predicted_velocity_m_s = (to.position_m - from.position_m) / step_s;
    if (from.unknown != bodies::kNoUnknown)
      fields_[i].predicted_angular_velocity_rad_s = to.angular_velocity_rad_s;
  }
}

/// False where the last iteration stalled, as at the onset of a contact: what it leads to then,
/// with speeds of its own making, is not where the step leads.
bool Prediction::solve(ImplicitStage& stage, Eigen::VectorXd& velocity, Budget budget) {
  budget.iterations = kMaxIterations - 1;
  const SolveReport first = solver_.solve(stage, velocity, budget);
  work_ = {.iterations = first.iterations, .products = first.products};
  if (first.converged || !std::isfinite(first.residual)) return first.converged;
  budget.iterations = 1;
  const SolveReport last = solver_.solve(stage, velocity, budget);
  work_.iterations += last.iterations;
  work_.products += last.products;
  return last.converged || last.residual < kProgress * first.residual;
}

/// What the step's equations lead to that are linear about where all is, at rest. Where the whole
/// ones stall, as of threads that fly, small steps do not.
bool Prediction::solve_linear(ImplicitStage& stage, Eigen::VectorXd& velocity,
                              const Budget& budget) {
  Eigen::VectorXd step;
  velocity.setZero();
  stage.residual(velocity, residual_);
  if (!linear_solver_.solve(stage, JacobianKind::kDefinite, residual_, kAccuracy, budget, step) ||
      budget.is_late())
    return false;
  velocity -= step;
  return true;
}

void Prediction::look(const bodies::World& world, std::span<const contact::Contact> contacts,
                      double step_s, std::span<const ContactMemory> kept, Budget budget,
                      std::size_t hand) {
  if (budget.has_deadline()) budget.end_within(realtime::to_ns(kMaxShare * step_s));
  spheres_.assign(world.spheres.size(), {});
  for (std::size_t i = 0; i < spheres_.size(); ++i)
    spheres_[i].predicted_velocity_m_s =
        bodies::sphere_motion(world, world.spheres[i]).velocity_m_s;
  move_fields_on(world);
  response_.clear();
  responses_.clear();
  snapshot_ = {.period_ns = static_cast<std::uint64_t>(std::llround(step_s * 1e9))};
  const auto tool =
      std::find_if(contacts.begin(), contacts.end(), [hand](const contact::Contact& contact) {
        return contact.is_tool && static_cast<std::size_t>(contact.hand) == hand;
      });
  take_contacts(world, {contacts.begin(), tool}, kept, step_s);
  PushedStage stage(system_, step_s);  // places all where it is
  take_tool(world, {tool, contacts.end()});

  const Eigen::VectorXd push = step_s * tool_force_;
  stage.push(push);
  Eigen::VectorXd velocity = stage.initial_guess();
  if (!solve(stage, velocity, budget) && !(is_explicit_ && solve_linear(stage, velocity, budget))) {
    // All moves on as it does, and gives way there.
    velocity = stage.initial_guess();
    stage.residual(velocity, residual_);
  }
  const long products = response_.products();
  response_.find(world, system_, stage, step_s, touches_, velocity, budget);
  work_.products += response_.products() - products;
  if (is_explicit_) response_.find_damping(system_, step_s);
  system_.place(step_s * velocity, velocity, step_s);
  for (std::size_t i = 0; i < spheres_.size(); ++i)
    spheres_[i].predicted_velocity_m_s =
        (system_.trial().spheres[i].position_m -
         bodies::sphere_motion(world, world.spheres[i]).position_m) /
        step_s;
  predict_fields(world, step_s);
  if (response_.modes().empty()) return;
  take_responses(world, {tool, contacts.end()});
  take_field_responses(world);
  snapshot_.modes = response_.modes();
  snapshot_.turning = response_.turning();
  snapshot_.responses = responses_;
}

}  // namespace stillgrid::dynamics
