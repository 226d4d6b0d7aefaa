#include "sim_server/dynamics/step/prediction.hpp"

#include <algorithm>
#include <cmath>

#include "sim_server/dynamics/integrators/implicit_stage.hpp"

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
/// Of the answer, relative.
constexpr double kAccuracy = 1e-4;
/// Of the forces on the tool, that their sum along the net one is where all of it responds: below,
/// they pinch more than they push.
constexpr double kLeastAlong = 0.5;

contact::SideMotion side_of(const bodies::World& world, int sphere) {
  const bodies::SphereBinding& binding = world.spheres[static_cast<std::size_t>(sphere)];
  const bodies::SphereMotion motion = bodies::sphere_motion(world, binding);
  contact::SideMotion side{motion.position_m, motion.velocity_m_s};
  if (binding.rigid >= 0)
    side.spin_rad_s =
        world.rigid_bodies[static_cast<std::size_t>(binding.rigid)].angular_velocity_rad_s;
  return side;
}

contact::ContactMotion motion_of(const bodies::World& world, const contact::Contact& contact) {
  return contact::relative_motion(
      contact, side_of(world, contact.a),
      contact.b >= 0 ? side_of(world, contact.b) : contact::kinematic_side(contact, 1.0));
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

Prediction::Prediction() : solver_(scene::SolverKind::kNewtonCg, kTolerance_m_s) {}

void Prediction::take_contacts(const bodies::World& world,
                               std::span<const contact::Contact> contacts, double step_s) {
  near_.clear();
  for (const contact::Contact& contact : contacts) {
    const contact::ContactMotion motion = motion_of(world, contact);
    const double depth_m = contact::contact_depth_m(contact, motion.position_m);
    if (depth_m + step_s * motion.velocity_m_s.norm() < 0.0) continue;
    near_.emplace_back(contact).depth_before_m = depth_m;
    near_.back().start_b_m = contact.position_b_m;
  }
}

/// The push of a newton of net force, on what that force presses. A tool between bodies has hardly
/// a net force while each body presses: divided by it the push would have no bound, and of the
/// wrong sign on one side. So it fades out as the net force does, and as the forces turn across it;
/// no contact is pushed with more than two newtons. A tool touched from one side has the whole
/// push.
double Prediction::push_ahead(const Eigen::Vector3d& net_N) {
  const Eigen::Vector3d direction = net_N.normalized();
  double ahead_N = 0.0, magnitudes_N = 0.0;
  for (const Touch& touch : touches_) {
    const double along_N = direction.dot(touch.force_N);
    if (!(along_N > 0.0)) continue;
    system_.push_sphere(*touch.sphere, touch.force_N, touch.couple_N_m, tool_push_);
    ahead_N += along_N;
    magnitudes_N += touch.force_N.norm();
  }
  const double along_share = std::min(1.0, ahead_N / (kLeastAlong * magnitudes_N));
  tool_push_ *= net_N.norm() / (ahead_N * ahead_N) * along_share * along_share;
  return ahead_N;
}

void Prediction::take_tool(const bodies::World& world, std::span<const contact::Contact> contacts) {
  tool_force_.setZero(system_.size());
  tool_push_.setZero(system_.size());
  touches_.clear();
  Eigen::Vector3d net_N = Eigen::Vector3d::Zero();
  const contact::Contact* nearest = nullptr;
  double nearest_m = 0.0;
  for (const contact::Contact& contact : contacts) {
    const bodies::SphereBinding& sphere = world.spheres[static_cast<std::size_t>(contact.a)];
    if (is_kinematic(world, sphere)) continue;
    const contact::ContactMotion motion = motion_of(world, contact);
    const double depth_m = contact::contact_depth_m(contact, motion.position_m);
    if (nearest == nullptr || depth_m > nearest_m) {
      nearest = &contact;
      nearest_m = depth_m;
    }
    const contact::ContactForce law = contact::contact_force(contact, motion, 0.0, nullptr);
    if (!law.touching) continue;
    const Eigen::Vector3d couple_N_m =
        -contact::contact_shares(contact).a * law.arm_m.cross(law.friction_N);
    touches_.push_back({&sphere, law.force_N, couple_N_m});
    system_.push_sphere(sphere, law.force_N, couple_N_m, tool_force_);
    net_N += law.force_N;
  }
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  if (const double norm_N = net_N.norm(); norm_N > 0.0) {
    direction = net_N / norm_N;
    snapshot_.compliance_force_N = push_ahead(net_N);
  } else if (nearest != nullptr && touches_.empty()) {
    direction = motion_of(world, *nearest).position_m.stableNormalized();
    system_.push_sphere(world.spheres[static_cast<std::size_t>(nearest->a)], direction,
                        Eigen::Vector3d::Zero(), tool_push_);
  }
  snapshot_.compliance_direction = {direction.x(), direction.y(), direction.z()};
}

/// False where the last iteration stalled, as at the onset of a contact: what it leads to then,
/// with speeds of its own making, is not where the step leads.
bool Prediction::solve(ImplicitStage& stage, Eigen::VectorXd& velocity, Budget budget) {
  budget.iterations = kMaxIterations - 1;
  const SolveReport first = solver_.solve(stage, velocity, budget);
  if (first.converged || !std::isfinite(first.residual)) return first.converged;
  budget.iterations = 1;
  const SolveReport last = solver_.solve(stage, velocity, budget);
  return last.converged || last.residual < kProgress * first.residual;
}

void Prediction::look(const bodies::World& world, std::span<const contact::Contact> contacts,
                      double step_s, Budget budget) {
  using Clock = std::chrono::steady_clock;
  if (budget.deadline != Clock::time_point::max())
    budget.deadline = std::min(
        budget.deadline, Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                            std::chrono::duration<double>(kMaxShare * step_s)));
  spheres_.assign(world.spheres.size(), {});
  for (std::size_t i = 0; i < spheres_.size(); ++i)
    spheres_[i].predicted_velocity_m_s =
        bodies::sphere_motion(world, world.spheres[i]).velocity_m_s;
  snapshot_ = {.period_ns = static_cast<std::uint64_t>(std::llround(step_s * 1e9))};
  const auto tool = std::find_if(contacts.begin(), contacts.end(),
                                 [](const contact::Contact& contact) { return contact.is_tool; });
  take_contacts(world, {contacts.begin(), tool}, step_s);
  system_.take(world, near_);
  PushedStage stage(system_, step_s);  // places all where it is
  take_tool(world, {tool, contacts.end()});

  const Eigen::VectorXd push = step_s * tool_force_;
  stage.push(push);
  Eigen::VectorXd velocity = stage.initial_guess(), change;
  if (!solve(stage, velocity, budget)) return;
  const bool answers = !tool_push_.isZero(0.0) && !budget.is_late() &&
                       linear_solver_.solve(stage, JacobianKind::kDefinite, step_s * tool_push_,
                                            kAccuracy, budget, change);
  system_.place(step_s * velocity, velocity, step_s);
  for (std::size_t i = 0; i < spheres_.size(); ++i)
    spheres_[i].predicted_velocity_m_s =
        (system_.trial().spheres[i].position_m -
         bodies::sphere_motion(world, world.spheres[i]).position_m) /
        step_s;
  if (!answers) return;
  system_.place(step_s * velocity, change, step_s);  // `change`: velocities a newton makes
  for (std::size_t i = 0; i < spheres_.size(); ++i) {
    if (is_kinematic(world, world.spheres[i])) continue;
    spheres_[i].compliance_m_per_N = step_s * system_.trial().spheres[i].velocity_m_s;
    snapshot_.max_compliance_m_per_N =
        std::max(snapshot_.max_compliance_m_per_N, spheres_[i].compliance_m_per_N.norm());
  }
}

}  // namespace stillgrid::dynamics
