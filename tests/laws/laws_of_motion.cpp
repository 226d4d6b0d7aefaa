// Laws of the simulation's motion alone: looking, order, frames, units.

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>

#include "shared/publication/scene_segment.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "sim_server/published_scene.hpp"
#include "tests/laws/law.hpp"
#include "tests/laws/moved_scene.hpp"

namespace stillgrid::laws {
namespace {

using Centres = std::vector<Eigen::Vector3d>;

/// How a scene is seen from elsewhere: mirrored at x = 0, turned, then moved, and moving.
struct Frame {
  bool mirrored = false;
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();

  [[nodiscard]] Eigen::Vector3d direction(Eigen::Vector3d v) const {
    if (mirrored) v.x() = -v.x();
    return turn * v;
  }
  [[nodiscard]] Eigen::Vector3d point(const Eigen::Vector3d& p) const {
    return direction(p) + shift_m;
  }
  /// A mirrored rotation turns the other way about what lies in the mirror's plane.
  [[nodiscard]] Eigen::Quaterniond orientation(const Eigen::Quaterniond& q) const {
    return turn * (mirrored ? Eigen::Quaterniond(q.w(), q.x(), -q.y(), -q.z()) : q);
  }
  [[nodiscard]] Eigen::Vector3d axial(const Eigen::Vector3d& v) const {
    return turn * (mirrored ? Eigen::Vector3d(v.x(), -v.y(), -v.z()) : v);
  }
};

scene::SceneDescription seen_from(const Frame& frame, scene::SceneDescription scene) {
  scene.gravity_m_s2 = frame.direction(scene.gravity_m_s2);
  for (bodies::BodyDescription& body : scene.bodies) {
    body.position_m = frame.point(body.position_m);
    body.orientation = frame.orientation(body.orientation);
    body.velocity_m_s = frame.direction(body.velocity_m_s) + frame.velocity_m_s;
    body.angular_velocity_rad_s = frame.axial(body.angular_velocity_rad_s);
    if (auto* plane = std::get_if<bodies::PlaneBody>(&body.shape))
      plane->normal = frame.direction(plane->normal);
    auto* const compound = std::get_if<bodies::CompoundBody>(&body.shape);
    if (compound != nullptr && frame.mirrored)
      for (bodies::SolidShape& shape : compound->shapes) {
        const Frame own{.mirrored = true};
        shape.position_m = own.point(shape.position_m);
        shape.orientation = own.orientation(shape.orientation);
      }
    if (auto* thread = std::get_if<bodies::ThreadBody>(&body.shape)) {
      thread->from_m = frame.point(thread->from_m);
      thread->to_m = frame.point(thread->to_m);
    }
    body.prescribed.velocity_m_s = frame.direction(body.prescribed.velocity_m_s);
    body.prescribed.direction = frame.direction(body.prescribed.direction);
    if (body.prescribed.keyframes) {
      bodies::PrescribedMotion::Keyframes keyframes = *body.prescribed.keyframes;
      for (dynamics::Keyframe& keyframe : keyframes)
        keyframe.displacement_m = frame.direction(keyframe.displacement_m);
      body.prescribed.keyframes =
          std::make_shared<const bodies::PrescribedMotion::Keyframes>(std::move(keyframes));
    }
  }
  for (scene::JointDescription& joint : scene.joints)
    for (Eigen::Vector3d& point : joint.points_m) point = frame.point(point);
  return scene;
}

ToolPath seen_from(const Frame& frame, const ToolPath& path) {
  return [frame, path](double time_s) {
    auto sample = path(time_s);
    if (sample) {
      sample->position_m = frame.point(sample->position_m) + time_s * frame.velocity_m_s;
      sample->velocity_m_s = frame.direction(sample->velocity_m_s) + frame.velocity_m_s;
      sample->orientation = frame.orientation(sample->orientation);
    }
    return sample;
  };
}

ToolPaths seen_from(const Frame& frame, ToolPaths paths) {
  for (ToolPath& path : paths) path = seen_from(frame, path);
  return paths;
}

Frame frame_of(const std::string& variant) {
  Frame frame;
  if (variant == "moved by 1 m") frame.shift_m = {1.0, 0.0, 0.0};
  if (variant == "turned by 90 degrees")
    frame.turn = Eigen::AngleAxisd(std::acos(0.0), Eigen::Vector3d::UnitX());
  if (variant == "mirrored") frame.mirrored = true;
  if (variant == "at 1 m/s") frame.velocity_m_s = {1.0, 0.0, 0.0};
  return frame;
}

/// How far the centres are apart once the solver leaves half as much.
double left_by_solver_m(const scene::SceneDescription& scene, const LawCase& law_case,
                        const ToolPaths& paths) {
  scene::SceneDescription finer = scene;
  finer.method.tolerance_m_s *= 0.5;
  return farthest_m(end_of(scene, law_case, paths), end_of(finer, law_case, paths));
}

/// What rounding may come to: a hundred times what a change of the last digits of all masses does,
/// or what solvers are asked to leave, or a hundred times what half of that changes.
double allowed_m(const scene::SceneDescription& scene, const LawCase& law_case,
                 const ToolPaths& paths) {
  const double changed_m = rounding_m(scene, law_case, paths);
  if (!scene::is_explicit(scene.method.integrator))
    return std::max({1e-8, 100.0 * changed_m, 100.0 * left_by_solver_m(scene, law_case, paths),
                     100.0 * scene.method.tolerance_m_s * law_case.duration_s});
  // They round the impulses of contacts to floats.
  constexpr double kFloatDigits = 1 << 29;
  return std::max(5e-6, kFloatDigits * changed_m);
}

/// The bodies' centres in the frame of `scene`, those of a reversed list in its order.
Finding compare(const Centres& one, const Centres& other, double allowed_m,
                const std::string& variant) {
  return {.measured = farthest_m(one, other),
          .allowed = allowed_m,
          .what = "m between centres, " + variant};
}

/// All that moves: places (m), velocities (m/s; rad/s) and turns.
Centres state_of(const bodies::World& world) {
  Centres state;
  for (const bodies::Node& node : world.nodes)
    state.insert(state.end(), {node.position_m, node.velocity_m_s});
  for (const bodies::RigidBody& body : world.rigid_bodies)
    state.insert(state.end(), {body.position_m, body.velocity_m_s, body.orientation.vec(),
                               body.angular_velocity_rad_s});
  return state;
}

Finding moved_by_looking(const LawCase& law_case, const scene::SceneDescription& scene,
                         const std::string& variant) {
  const ToolPaths paths = tool_paths_of(law_case);
  std::vector<Centres> plain;
  move_scene(scene, law_case, paths,
             [&](dynamics::Simulation& simulation, const dynamics::StepReport&, double) {
               plain.push_back(state_of(simulation.world()));
               return true;
             });
  double worst_m = 0.0;
  std::size_t step = 0;
  std::optional<publication::SceneWriter> writer;
  std::uint64_t stamp_ns = 0;
  move_scene(scene, law_case, paths,
             [&](dynamics::Simulation& simulation, const dynamics::StepReport&, double) {
               if (variant == "accounted") {
                 if (step == 0) simulation.account_energy();
                 (void)simulation.energy_account();
               }
               if (variant == "published") {
                 if (!writer)
                   writer.emplace("law-" + std::to_string(::getpid()),
                                  sim_server::static_scene(scene, simulation),
                                  simulation.world().spheres.size(),
                                  realtime::to_ns(scene.period_s), proto::Clock::kVirtual, 0);
                 writer->publish(simulation.snapshot(),
                                 {.state_ns = stamp_ns, .publish_ns = stamp_ns},
                                 simulation.field_records());
                 stamp_ns += 1000;
               }
               worst_m = std::max(worst_m, farthest_m(plain[step++], state_of(simulation.world())));
               return true;
             });
  return {
      .measured = worst_m, .allowed = 0.0, .what = "m, m/s or rad/s between states, " + variant};
}

}  // namespace

Finding looking_changes_nothing(const LawCase& law_case) {
  const scene::SceneDescription scene = scene_of(law_case);
  return moved_by_looking(law_case, scene, law_case.variant);
}

Finding order_and_frame_change_nothing(const LawCase& law_case) {
  const scene::SceneDescription scene = scene_of(law_case);
  const ToolPaths paths = tool_paths_of(law_case);
  const double allowed = allowed_m(scene, law_case, paths);
  Centres plain = end_of(scene, law_case, paths);
  if (law_case.variant == "reversed list") {
    scene::SceneDescription reversed = scene;
    std::reverse(reversed.bodies.begin(), reversed.bodies.end());
    std::reverse(reversed.hands.begin(), reversed.hands.end());
    for (scene::JointDescription& joint : reversed.joints)
      for (int* const body : {&joint.body_a, &joint.body_b})
        if (*body >= 0) *body = static_cast<int>(scene.bodies.size()) - 1 - *body;
    Centres other = end_of(reversed, law_case, {paths.rbegin(), paths.rend()});
    std::reverse(other.begin(), other.end());
    return compare(plain, other, allowed, law_case.variant);
  }
  const Frame frame = frame_of(law_case.variant);
  Centres other = end_of(seen_from(frame, scene), law_case, seen_from(frame, paths));
  double end_s = 0.0;
  move_scene(scene, law_case, paths,
             [&](dynamics::Simulation&, const dynamics::StepReport&, double time_s) {
               end_s = time_s;
               return true;
             });
  for (Eigen::Vector3d& centre : plain) centre = frame.point(centre) + end_s * frame.velocity_m_s;
  return compare(plain, other, allowed, law_case.variant);
}

template <class Shape>
void scale_springs(Shape& shape, double factor) {
  if constexpr (requires { shape.springs; }) {
    shape.springs.structural_stiffness_N_per_m *= factor;
    shape.springs.bend_stiffness_N_per_m *= factor;
    shape.springs.spring_damping_N_s_per_m *= factor;
  }
  if constexpr (requires { shape.springs.shear_stiffness_N_per_m; })
    shape.springs.shear_stiffness_N_per_m *= factor;
}

Finding units_change_nothing(const LawCase& law_case) {
  constexpr double kUnit = 10.0;
  const scene::SceneDescription scene = scene_of(law_case);
  scene::SceneDescription other = scene;
  for (scene::MaterialDescription& material : other.materials) {
    material.contact_stiffness_N_per_m *= kUnit;
    material.contact_damping_N_s_per_m *= kUnit;
  }
  for (bodies::BodyDescription& body : other.bodies) {
    body.mass_kg *= kUnit;
    std::visit([](auto& shape) { scale_springs(shape, kUnit); }, body.shape);
  }
  for (scene::JointDescription& joint : other.joints) {
    joint.stiffness_N_per_m *= kUnit;
    joint.damping_N_s_per_m *= kUnit;
  }
  const ToolPaths paths = tool_paths_of(law_case);
  const double allowed = allowed_m(scene, law_case, paths);
  if (law_case.variant != "force")
    return compare(end_of(scene, law_case, paths), end_of(other, law_case, paths), allowed,
                   "masses and stiffnesses times 10");

  const CaseLoop loop = loop_of(law_case, scene);
  const laboratory::LabRun one = laboratory::run_lab(scene, loop.options),
                           ten = laboratory::run_lab(other, loop.options);
  double most_N = 0.0, worst_N = 0.0, at_s = 0.0, stiffest_N_per_m = 0.0;
  for (const scene::MaterialDescription& material : scene.materials)
    stiffest_N_per_m = std::max(stiffest_N_per_m, material.contact_stiffness_N_per_m);
  for (std::size_t i = 0; i < std::min(one.rows.size(), ten.rows.size()); ++i) {
    const double apart_N = (kUnit * one.rows[i].rendered_N - ten.rows[i].rendered_N).norm();
    most_N = std::max(most_N, kUnit * one.rows[i].rendered_N.norm());
    if (apart_N > worst_N) {
      worst_N = apart_N;
      at_s = one.rows[i].time_s;
    }
  }
  return {.measured = worst_N,
          .allowed = 1e-5 * most_N + 1e-6 + 100.0 * kUnit * stiffest_N_per_m * allowed,
          .what = "N between ten times the force and that of ten times the scene, at " +
                  short_number(at_s) + " s"};
}

}  // namespace stillgrid::laws
