#include "sim_server/report.hpp"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>

#include "shared/files/json_file.hpp"
#include "shared/files/whole_file.hpp"
#include "shared/reading/histogram_json.hpp"
#include "shared/reading/relay_json.hpp"

namespace stillgrid::sim_server {
namespace {

nlohmann::json vector_json(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

nlohmann::json energy_json(const dynamics::EnergyAccount& account, double tool_work_J) {
  return {{"kinetic_J", account.end.kinetic_J},
          {"gravity_J", account.end.gravity_J},
          {"springs_J", account.end.springs_J},
          {"contacts_J", account.end.contacts_J},
          {"start_J", account.start.total_J()},
          {"given_J", account.flow.given_J},
          {"tool_work_J", tool_work_J},
          {"proxies_J", account.flow.proxies_J},
          {"spring_damping_J", account.flow.spring_damping_J},
          {"contact_damping_J", account.flow.contact_damping_J},
          {"friction_J", account.flow.friction_J},
          {"sleep_loss_J", account.sleep_loss_J},
          {"numerical_J", account.numerical_J()}};
}

/// Of all hands.
double tool_work_J(const SimulationReport& report) {
  double sum_J = 0.0;
  for (const HandReport& hand : report.hands) sum_J += hand.tool_work_J;
  return sum_J;
}

/// A hand without a name is the only one: what is said of it is said of the run.
void add_hands(const SimulationReport& report, nlohmann::json& json) {
  for (const HandReport& hand : report.hands) {
    nlohmann::json own = {{"name", hand.name}, {"tool_work_J", hand.tool_work_J}};
    if (hand.tool_age_ns.count() > 0)
      (hand.name.empty() ? json : own)["tool_age_ms"] =
          reading::histogram_json(hand.tool_age_ns, 1e-6);
    if (hand.relay) (hand.name.empty() ? json : own)["relay"] = reading::relay_json(hand.relay);
    if (!hand.name.empty()) json["hands"].push_back(own);
  }
}

}  // namespace

std::string convergence_complaint(const SimulationReport& report, const scene::Method& method) {
  const std::uint64_t late = report.out_of_budget;
  const std::uint64_t unsolved = std::max(report.not_converged, late);
  if (unsolved == 0) return "";
  const bool is_explicit = scene::is_explicit(method.integrator);
  std::string line = std::to_string(unsolved) + " of " + std::to_string(report.steps) + " steps " +
                     (is_explicit ? "did not solve their contacts" : "did not converge");
  if (late > 0) line += ", " + std::to_string(late) + " of them out of time or iterations";
  line += is_explicit ? "; softer contacts or a higher rate_hz help"
                      : "; a higher rate_hz, softer springs and contacts, or integrator = "
                        "\"velocity_verlet\" help";
  return line;
}

std::string lateness_complaint(const SimulationReport& report) {
  if (report.late_steps <= report.steps) return "";
  return std::to_string(report.late_steps) + " of " +
         std::to_string(report.steps + report.late_steps) +
         " deadlines passed without a step: simulated time fell behind; a lower rate_hz or a "
         "machine with less to do helps";
}

void count_step(SimulationReport& report, const dynamics::StepReport& step) {
  ++report.steps;
  report.solver_iterations += static_cast<std::uint64_t>(step.solve.iterations);
  report.not_converged += step.solve.converged ? 0 : 1;
  report.out_of_budget += step.out_of_budget ? 1 : 0;
  report.sleeping_spheres += static_cast<std::uint64_t>(step.sleeping_spheres);
  report.substeps += static_cast<std::uint64_t>(step.substeps);
  report.divided += step.substeps > 1 ? 1 : 0;
  report.crossings_left += static_cast<std::uint64_t>(step.crossings_left);
  report.contacts += static_cast<std::uint64_t>(step.contacts);
  for (std::size_t hand = 0; hand < report.hands.size(); ++hand)
    report.hands[hand].tool_work_J = step.tools[hand].work_J;
  if (!report.measures_time) return;
  const auto ns = [](std::chrono::nanoseconds t) { return static_cast<std::uint64_t>(t.count()); };
  report.integrate_ns.record(ns(step.integrate));
}

void count_snapshot(SimulationReport& report, std::size_t hand,
                    const publication::SnapshotTimes& times, bool has_state) {
  if (hand == 0) ++report.snapshots;
  if (hand == 0 && has_state) ++report.states;
  if (times.tool_ns != 0) report.hands[hand].tool_age_ns.record(times.publish_ns - times.tool_ns);
}

void write_report(const SimulationReport& report, const bodies::World& world,
                  const std::filesystem::path& file) {
  const double steps = static_cast<double>(report.steps > 0 ? report.steps : 1);
  nlohmann::json json = {{"scene", report.scene},
                         {"steps", report.steps},
                         {"late_steps", report.late_steps},
                         {"left_out_s", static_cast<double>(report.left_out_ticks) * 1e-3},
                         {"rate_hz", report.rate_hz},
                         {"simulated_s", world.time_s},
                         {"spheres", world.spheres.size() + world.static_spheres.size()},
                         {"moving_spheres", world.spheres.size()},
                         {"sleeping_spheres", static_cast<double>(report.sleeping_spheres) / steps},
                         {"contacts", static_cast<double>(report.contacts) / steps},
                         {"solver",
                          {{"name", report.solver},
                           {"iterations", static_cast<double>(report.solver_iterations) / steps},
                           {"not_converged", report.not_converged},
                           {"out_of_budget", report.out_of_budget}}},
                         {"substeps", static_cast<double>(report.substeps) / steps},
                         {"divided", report.divided},
                         {"crossings_left", report.crossings_left},
                         {"energy_J", bodies::mechanical_energy_J(world)},
                         {"snapshots", report.snapshots},
                         {"states", report.states}};
  if (!report.ended_by.empty()) json["ended_by"] = report.ended_by;
  if (report.energy) json["energy"] = energy_json(*report.energy, tool_work_J(report));
  json["momentum_kg_m_per_s"] = vector_json(dynamics::momentum_kg_m_per_s(world));
  json["angular_momentum_kg_m2_per_s"] = vector_json(dynamics::angular_momentum_kg_m2_per_s(world));
  add_hands(report, json);
  if (report.measures_time) {
    json["step_ms"] = reading::histogram_json(report.step_ns, 1e-6);
    json["phases_ms"] = {{"integrate", reading::histogram_json(report.integrate_ns, 1e-6)}};
    if (report.publish_ns.count() > 0) {
      json["phases_ms"]["publish"] = reading::histogram_json(report.publish_ns, 1e-6);
    }
  }
  files::write_json(file, json);
}

void write_final_state(const bodies::World& world, const std::filesystem::path& file) {
  files::write_whole(file, [&](std::ostream& out) {
    out.precision(std::numeric_limits<double>::max_digits10);
    out << "body,node,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s\n";
    const auto row = [&](const std::string& name, int node, const Eigen::Vector3d& x,
                         const Eigen::Vector3d& v) {
      out << name << ',' << node << ',' << x.x() << ',' << x.y() << ',' << x.z() << ',' << v.x()
          << ',' << v.y() << ',' << v.z() << '\n';
    };
    for (const bodies::BodyRange& body : world.bodies) {
      for (int i = 0; i < body.node_count; ++i) {
        const bodies::Node& node = world.nodes[static_cast<std::size_t>(body.first_node + i)];
        row(body.name, i, node.position_m, node.velocity_m_s);
      }
      if (body.rigid < 0) continue;
      const bodies::RigidBody& rigid = world.rigid_bodies[static_cast<std::size_t>(body.rigid)];
      row(body.name, 0, rigid.position_m, rigid.velocity_m_s);
    }
  });
}

}  // namespace stillgrid::sim_server
