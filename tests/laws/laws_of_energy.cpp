// Laws of energy: across the interface, by limits, and at rest.

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "haptic_server/device/device_host.hpp"
#include "haptic_server/safety/device_limits.hpp"
#include "haptic_server/safety/safety_flag.hpp"
#include "sim_server/scene/build_world.hpp"
#include "tests/laws/law.hpp"
#include "tests/laws/moved_scene.hpp"

namespace stillgrid::laws {
namespace {

/// Work of a held force on the hand up to each tick, of the device's own way.
std::vector<double> work_J(const std::vector<recording::TickRow>& rows,
                           Eigen::Vector3d recording::TickRow::*force, double scale) {
  std::vector<double> work(rows.size(), 0.0);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const Eigen::Vector3d moved_m = (rows[i].position_m - rows[i - 1].position_m) / scale;
    work[i] = work[i - 1] + (rows[i - 1].*force).dot(moved_m);
  }
  return work;
}

double stiffness_least_N_per_m(const scene::SceneDescription& scene) {
  double least = std::numeric_limits<double>::infinity();
  for (const scene::MaterialDescription& material : scene.materials)
    least = std::min(least, material.contact_stiffness_N_per_m);
  return least;
}

double damping_most_N_s_per_m(const scene::SceneDescription& scene) {
  double most = 0.0;
  for (const scene::MaterialDescription& material : scene.materials)
    most = std::max(most, material.contact_damping_N_s_per_m);
  return most;
}

/// The most that dampers of 1 N s/m take at the simulation and not at the hand: there they see an
/// estimate of the tool's velocity, which is late by 5 ms.
double late_damping_J_per_N_s_per_m(const std::vector<recording::TickRow>& rows) {
  double sum = 0.0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const recording::TickRow &row = rows[i], &before = rows[i - 1];
    const Eigen::Vector3d moved_m = row.position_m - before.position_m;
    const Eigen::Vector3d slope_m_s = moved_m / (row.time_s - before.time_s);
    sum += std::max(row.contacts, before.contacts) * (slope_m_s - row.velocity_m_s).norm() *
           moved_m.norm();
  }
  return sum;
}

/// The most that a force makes which is held over each tick, where it grows evenly within it.
double hold_J(const std::vector<recording::TickRow>& rows) {
  double sum = 0.0;
  for (std::size_t i = 1; i < rows.size(); ++i)
    sum += std::abs((rows[i].rendered_N - rows[i - 1].rendered_N)
                        .dot(rows[i].position_m - rows[i - 1].position_m));
  return sum;
}

/// Whether there is a floor, dampers and friction take energy wherever it can go, and there is
/// time.
bool is_to_rest(const scene::SceneDescription& scene, double duration_s) {
  constexpr double kLongEnough_s = 10.0;
  const auto takes = [](const scene::MaterialDescription& material) {
    return material.contact_damping_N_s_per_m > 0.0 && material.friction > 0.0;
  };
  const auto is_damped = [](const bodies::BodyDescription& body) {
    const bodies::SpringDescription* springs = bodies::springs_of(body);
    return springs == nullptr || springs->spring_damping_N_s_per_m > 0.0;
  };
  const auto is_floor = [](const bodies::BodyDescription& body) {
    return std::holds_alternative<bodies::PlaneBody>(body.shape);
  };
  return duration_s >= kLongEnough_s &&
         std::all_of(scene.materials.begin(), scene.materials.end(), takes) &&
         std::all_of(scene.bodies.begin(), scene.bodies.end(), is_damped) &&
         std::any_of(scene.bodies.begin(), scene.bodies.end(), is_floor);
}

}  // namespace

Finding interface_makes_nothing(const LawCase& law_case) {
  const scene::SceneDescription scene = scene_of(law_case);
  const CaseLoop loop = loop_of(law_case, scene);
  const laboratory::LabRun run = laboratory::run_lab(scene, loop.options);
  if (!run.report.interface)
    return {.measured = std::numeric_limits<double>::infinity(), .what = "no account"};
  const safety::InterfaceEnergy& account = *run.report.interface;
  double most_N = 0.0;
  for (const recording::TickRow& row : run.rows) most_N = std::max(most_N, row.rendered_N.norm());
  // Without a copy what the springs of contact hold is with the simulation a while before or after
  // the hand. No copy takes steps of CVODE.
  const bool has_copy =
      law_case.transition == "local" && scene.method.integrator != scene::IntegratorKind::kCvodeBdf;
  const double held_J = has_copy ? 0.0 : 0.5 * most_N * most_N / stiffness_least_N_per_m(scene);
  const double late_J = damping_most_N_s_per_m(scene) * late_damping_J_per_N_s_per_m(run.rows);
  Finding finding{.measured = account.most_made_in_a_second_J.value_or(0.0),
                  .allowed = 2.0 * (hold_J(run.rows) + held_J) + late_J + 5e-6,
                  .what = "J made by the interface over a second or longer"};
  // Nor does it lose more than the hand put in at most: what one side books with the wrong sign
  // does.
  double put_in_J = 0.0;
  for (const double work : work_J(run.rows, &recording::TickRow::rendered_N, 1.0))
    put_in_J = std::max(put_in_J, -work);
  if (finding.holds() && -account.made_J > put_in_J + finding.allowed)
    return {.measured = -account.made_J,
            .allowed = put_in_J + finding.allowed,
            .what = "J lost by the interface"};
  return finding;
}

namespace {

/// A limit takes no more than it says: a force without torque whose growth along one direction is
/// cut grows by the whole of the limit, but for a rounding.
Finding slew_is_whole(const CaseLoop& loop, const laboratory::LabRun& run, double scale) {
  const device::Device device(device::parse_device_spec(loop.options.device), {.is_virtual = true});
  const safety::SafetyLimits limits =
      safety::safety_limits(loop.options.safety, device.descriptor());
  const double whole_N = limits.max_slew_N_per_ms * 1e3 / loop.options.tick_rate_hz;
  Finding finding{.allowed = 0.1, .what = "of the slew limit that a cut growth left unused"};
  for (std::size_t i = 1; i < run.rows.size(); ++i) {
    const recording::TickRow &row = run.rows[i], &before = run.rows[i - 1];
    const double commanded_N = row.force_N.norm(), before_N = before.force_N.norm();
    const bool is_along = row.force_N.dot(before.force_N) > 0.9999 * commanded_N * before_N;
    constexpr std::uint32_t kOdd =
        safety::kFlagContended | safety::kFlagTruncated | safety::kFlagSwept;
    if ((row.flags & ~kOdd) != safety::kFlagSlewed || !is_along || before_N < 0.05 * whole_N)
      continue;
    if (commanded_N < before_N) continue;
    if (row.torque_N_m.norm() > 1e-6 * scale * limits.lever_m * commanded_N) continue;
    finding.measured = std::max(finding.measured, 1.0 - (commanded_N - before_N) / whole_N);
  }
  return finding;
}

/// The ramp at the start is no limit: a force that sets in on a hand that is there already is new.
/// The account begins behind its last tick with a force, with the run where there is none: begun
/// later, in a contact, it would take for a gift what the contact gives back.
std::size_t account_begins(const std::vector<recording::TickRow>& rows, double tick_rate_hz) {
  constexpr double kLongestRamp_s = 0.12;
  const auto longest = static_cast<std::size_t>(kLongestRamp_s * tick_rate_hz);
  std::size_t first = 0;
  for (std::size_t i = 0; i < std::min(longest, rows.size()); ++i)
    if ((rows[i].flags & safety::kFlagRamped) != 0 && !rows[i].rendered_N.isZero()) first = i + 1;
  return std::min(first, rows.size() - 1);
}

}  // namespace

Finding limits_are_passive(const LawCase& law_case) {
  const scene::SceneDescription scene = scene_of(law_case);
  const CaseLoop loop = loop_of(law_case, scene);
  const laboratory::LabRun run = laboratory::run_lab(scene, loop.options);
  if (Finding whole = slew_is_whole(loop, run, scene.device.scale); !whole.holds()) return whole;
  const std::vector<double> told =
      work_J(run.rows, &recording::TickRow::force_N, scene.device.scale);
  const std::vector<double> free =
      work_J(run.rows, &recording::TickRow::rendered_N, scene.device.scale);
  const std::size_t first = account_begins(run.rows, loop.options.tick_rate_hz);
  // What was withheld comes back while the hand rests: at most what contacts store.
  const double least_N_per_m = stiffness_least_N_per_m(scene);
  double most_commanded_J = 0.0, most_free_J = 0.0, taken_J = 0.0, returned_J = 0.0;
  for (std::size_t i = first; i < run.rows.size(); ++i) {
    most_commanded_J = std::max(most_commanded_J, told[i] - told[first]);
    most_free_J = std::max(most_free_J, free[i] - free[first]);
    taken_J = std::max(taken_J, free[first] - free[i]);
    if ((run.rows[i].flags & safety::kFlagEnergy) != 0)
      returned_J = std::max(returned_J, 0.5 * run.rows[i].rendered_N.squaredNorm() / least_N_per_m);
  }
  return {.measured = most_commanded_J,
          .allowed = most_free_J + 1e-4 + 0.01 * taken_J + returned_J,
          .what = "J given to the hand by the limited force at most; allowed: the unlimited one"};
}

Finding comes_to_rest(const LawCase& law_case) {
  const scene::SceneDescription scene = scene_of(law_case);
  if (!is_to_rest(scene, law_case.duration_s))
    return {.applies = false, .what = "nothing that is to rest"};
  std::size_t spheres = 0, is_sleeping = 0;
  double half_J = 0.0, end_J = 0.0, half_flow_J = 0.0, end_flow_J = 0.0, most_J = 0.0;
  double end_s = 0.0, half_s = 0.0, fastest_J = 0.0;
  const double look_s = 0.75 * law_case.duration_s;
  move_scene(
      scene, law_case, tool_paths_of(law_case),
      [&](dynamics::Simulation& simulation, const dynamics::StepReport& report, double time_s) {
        if (time_s == 0.0 || end_s == 0.0) simulation.account_energy();
        end_s = time_s;
        is_sleeping = static_cast<std::size_t>(report.sleeping_spheres);
        spheres = 0;
        for (const bodies::SphereBinding& sphere : simulation.world().spheres) {
          const int rigid = sphere.rigid;
          if (rigid < 0 || simulation.world().rigid_bodies[static_cast<std::size_t>(rigid)].free)
            ++spheres;
        }
        const bool is_end = time_s >= law_case.duration_s;
        if (!is_end && (time_s < look_s || half_s > 0.0)) return true;
        const auto account = simulation.energy_account();
        const double flow_J = std::abs(account->flow.friction_J) +
                              std::abs(account->flow.spring_damping_J) +
                              std::abs(account->flow.contact_damping_J);
        (is_end ? end_J : half_J) = account->end.total_J();
        (is_end ? end_flow_J : half_flow_J) = flow_J;
        most_J = std::max(most_J, account->start.total_J() - account->end.gravity_J);
        fastest_J = account->end.kinetic_J;
        if (!is_end) half_s = time_s;
        return true;
      });
  // Nothing that is said to rest moves faster than a millimetre a second, or warms up.
  double mass_kg = 0.0;
  for (const bodies::BodyDescription& body : scene.bodies) mass_kg += body.mass_kg;
  const double rate_W = std::abs(end_flow_J - half_flow_J) / std::max(1e-3, end_s - half_s);
  const double rise_W = (end_J - half_J) / std::max(1e-3, end_s - half_s);
  const double still_J = 0.5 * mass_kg * 1e-6;
  const double still_W = 1e-3 * mass_kg * 1e-3;
  if (!std::isfinite(end_J))
    return {.measured = std::numeric_limits<double>::infinity(), .what = "energy is no number"};
  if (fastest_J > still_J)
    return {.measured = fastest_J, .allowed = still_J, .what = "J of motion at the end"};
  if (rise_W > still_W)
    return {.measured = rise_W, .allowed = still_W, .what = "W by which the energy grows at rest"};
  if (rate_W > still_W)
    return {.measured = rate_W, .allowed = still_W, .what = "W by which accounts grow at rest"};
  const double awake = static_cast<double>(spheres) - static_cast<double>(is_sleeping);
  return {.measured = scene.sleeping ? awake : 0.0, .allowed = 0.0, .what = "spheres awake"};
}

Finding nothing_gains_energy(const LawCase& law_case) {
  const scene::SceneDescription scene = scene_of(law_case);
  const bodies::World start = scene::build_world(scene);
  const auto is_kinematic = [](const bodies::RigidBody& body) { return !body.free; };
  if (law_case.hand || !law_case.device.empty() ||
      std::any_of(start.rigid_bodies.begin(), start.rigid_bodies.end(), is_kinematic))
    return {.applies = false, .what = "something is led"};
  dynamics::Simulation at_start(scene);
  at_start.account_energy();
  const double start_J = at_start.energy_account()->start.total_J();
  double most_kinetic_J = 0.0;
  Finding finding{.what = "J"};
  move_scene(scene, law_case, tool_paths_of(law_case),
             [&](dynamics::Simulation& simulation, const dynamics::StepReport&, double time_s) {
               if (!simulation.energy_account()) simulation.account_energy();
               const dynamics::Energies now = simulation.energy_account()->end;
               const double gain_J = now.total_J() - start_J;
               most_kinetic_J = std::max(most_kinetic_J, now.kinetic_J);
               if (gain_J <= finding.measured) return std::isfinite(gain_J);
               finding.measured = gain_J;
               finding.what = "J gained by " + short_number(time_s) + " s";
               return true;
             });
  // By implicit Euler what rounding and the solver leave; by explicit methods their error.
  const bool is_implicit = scene.method.integrator == scene::IntegratorKind::kImplicitEuler;
  const double explicit_share = start.springs.empty() ? 1e-3 : 0.02;
  const double share = is_implicit ? 1e-6 : explicit_share;
  finding.allowed = share * most_kinetic_J;
  return finding;
}

}  // namespace stillgrid::laws
