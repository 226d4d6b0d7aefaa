#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <string>

namespace stillgrid::recording {

/// One tick as recorded; docs/formats.md, "Recordings". Scene frame, SI units.
struct TickRow {
  double time_s = 0.0;  // since the loop began
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();     // that the device was told
  Eigen::Vector3d rendered_N = Eigen::Vector3d::Zero();  // before the safety chain
  std::uint64_t snapshot_id = 0;
  double alpha = 1.0;
  int contacts = 0;
  double age_s = 0.0;
  std::uint64_t tick_ns = 0;
  std::uint32_t flags = 0;
  Eigen::Vector3d torque_N_m = Eigen::Vector3d::Zero();             // that the device was told
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  // of the tool
  std::uint64_t clock_ns = 0;                                       // of the loop, at this tick
};

/// The names of the flags that are set, joined by bars.
void append_flags(std::uint32_t flags, std::string& text);

}  // namespace stillgrid::recording
