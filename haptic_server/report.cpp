#include "haptic_server/report.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "shared/files/json_file.hpp"
#include "shared/reading/histogram_json.hpp"
#include "shared/reading/relay_json.hpp"

namespace stillgrid::haptic_server {
namespace {

constexpr double kMicro = 1e-6;

/// Saturating; what is no number counts as the most.
std::uint64_t to_micro(double value) {
  return value < 1e12 ? static_cast<std::uint64_t>(std::llround(value * 1e6))
                      : std::uint64_t{1} << 60U;
}

nlohmann::json interface_json(const std::optional<safety::InterfaceEnergy>& energy) {
  if (!energy) return {};
  const auto& [given_by_hand_J, booked_J, held_J, made_J, in_flight_J, uncertainty_J, noise_J,
               most_made_J] = *energy;
  return {
      {"given_by_hand_J", given_by_hand_J},
      {"booked_J", booked_J},
      {"held_J", held_J},
      {"made_J", made_J},
      {"in_flight_J", in_flight_J},
      {"uncertainty_J", uncertainty_J},
      {"noise_J", noise_J},
      {"most_made_in_a_second_J", most_made_J ? nlohmann::json(*most_made_J) : nlohmann::json()}};
}

/// Names of STILLGRID_DOF_..., null where they are not told.
nlohmann::json dof_json(std::uint32_t mask) {
  constexpr std::array kNames = {"x", "y", "z", "about_x", "about_y", "about_z", "gripper"};
  nlohmann::json names;
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if ((mask >> i & 1U) != 0) names.push_back(kNames[i]);
  return names;
}

/// What a device said it is; zero: not told.
nlohmann::json declared_json(const stillgrid_device_descriptor& device) {
  return {{"sets_pace", (device.flags & STILLGRID_DEVICE_SETS_PACE) != 0},
          {"dof_sensed", dof_json(device.dof_sensed)},
          {"dof_actuated", dof_json(device.dof_actuated)},
          {"buttons", device.button_count},
          {"axes", device.axis_count},
          {"max_force_N", device.max_force_N},
          {"continuous_force_N", device.continuous_force_N},
          {"max_torque_N_m", device.max_torque_N_m},
          {"continuous_torque_N_m", device.continuous_torque_N_m},
          {"nominal_stiffness_N_per_m", device.nominal_stiffness_N_per_m},
          {"gripper_open_m", device.gripper_open_m},
          {"max_gripper_force_N", device.max_gripper_force_N}};
}

nlohmann::json counts(const std::vector<realtime::RealtimeViolation>& violations) {
  nlohmann::json json;
  std::uint64_t total = 0;
  for (const realtime::RealtimeViolation& violation : violations) {
    json[violation.call] = violation.count;
    total += violation.count;
  }
  json["total"] = total;
  return json;
}

}  // namespace

void count_tick(HapticReport& report, const recording::TickRow& row,
                const rendering::RenderedTick& rendered, const Eigen::Vector3d& previous_N,
                const Eigen::Vector3d& moved_m, double tick_s) noexcept {
  ++report.ticks;
  report.contact_ticks += row.contacts > 0 ? 1 : 0;
  report.contended += rendered.contended ? 1 : 0;
  for (std::size_t i = 0; i < report.flags.size(); ++i) report.flags[i] += (row.flags >> i) & 1U;
  const double force_N = row.force_N.norm();
  report.force_sum_N += force_N;
  report.force_max_N = std::max(report.force_max_N, force_N);
  report.energy_J += previous_N.dot(moved_m);
  report.slew_uN_per_ms.record(to_micro((row.force_N - previous_N).norm() / (tick_s * 1e3)));
  if (rendered.switch_jump_N) report.switch_jump_uN.record(to_micro(*rendered.switch_jump_N));
  report.local += rendered.is_local ? 1 : 0;
  report.swaps += rendered.is_swap ? 1 : 0;
  if (rendered.is_local)
    report.local_ticks.record(static_cast<std::uint64_t>(rendered.local_ticks));
  if (rendered.snapshot_id != 0) {
    report.plateau_ticks += rendered.weights.is_waiting ? 1 : 0;
    report.age_ns.record(static_cast<std::uint64_t>(rendered.age_s * 1e9));
  }
  if (report.measures_time) report.tick_ns.record(row.tick_ns);
}

void write_report(const HapticReport& report, const std::filesystem::path& file) {
  const double ticks = static_cast<double>(std::max<std::uint64_t>(report.ticks, 1));
  nlohmann::json safety;
  for (std::size_t i = 0; i < report.flags.size(); ++i)
    safety[std::string(safety::kSafetyFlagNames[i])] = report.flags[i];
  nlohmann::json json = {
      {"scene", report.scene},
      {"device", report.device},
      {"device_identity",
       {{"serial", report.device_identity.serial},
        {"firmware", report.device_identity.firmware},
        {"driver", report.device_identity.driver}}},
      {"transition", report.transition},
      {"ticks", report.ticks},
      {"missed_ticks", report.missed_ticks},
      {"contact_ticks", report.contact_ticks},
      {"rate_hz", report.rate_hz},
      {"snapshots", report.snapshots},
      {"contended", report.contended},
      {"age_s", reading::histogram_json(report.age_ns, 1e-9)},
      {"force_N", {{"mean", report.force_sum_N / ticks}, {"max", report.force_max_N}}},
      {"slew_N_per_ms", reading::histogram_json(report.slew_uN_per_ms, kMicro)},
      {"switch_jump_N", reading::histogram_json(report.switch_jump_uN, kMicro)},
      {"local",
       {{"ticks", report.local},
        {"swaps", report.swaps},
        {"simulated_ticks", reading::histogram_json(report.local_ticks, 1.0)}}},
      {"plateau_share", static_cast<double>(report.plateau_ticks) / ticks},
      {"energy_J", report.energy_J},
      {"energy",
       {{"given_J", report.energy.given_J},
        {"most_given_J", report.energy.most_given_J},
        {"dissipated_by_control_J", report.energy.dissipated_by_control_J}}},
      {"interface", interface_json(report.interface)},
      {"safety", safety},
      {"declared", declared_json(report.descriptor)},
      {"device_stops", report.device_stops},
      {"reopenings", report.reopenings},
      {"temperature_max_C",
       report.temperature_max_C ? nlohmann::json(*report.temperature_max_C) : nlohmann::json()},
      {"lost_rows", report.lost_rows},
      {"page_faults", report.page_faults}};
  if (report.measures_time) {
    json["scheduling"] = {{"way", realtime::way_name(report.rights)},
                          {"priority", report.rights.priority},
                          {"was_demoted", realtime::was_demoted()},
                          {"is_memory_locked", report.rights.is_memory_locked}};
    json["tick_ns"] = reading::histogram_json(report.tick_ns, 1.0);
    json["wake_ns"] = reading::histogram_json(report.wake_ns, 1.0);
  }
  if (report.relay) json["relay"] = reading::relay_json(report.relay);
  if (report.realtime_violations) json["realtime_violations"] = counts(*report.realtime_violations);
  files::write_json(file, json);
}

}  // namespace stillgrid::haptic_server
