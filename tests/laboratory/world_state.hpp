#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <vector>

#include "sim_server/bodies/world.hpp"

namespace stillgrid::laboratory {

/// All of a world that changes as it moves: a run can begin where another one was.
struct WorldState {
  struct Point {
    Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  };
  struct Rigid : Point {
    Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
    Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();  // world frame
  };
  double time_s = 0.0;
  std::vector<Point> nodes;         // as World::nodes
  std::vector<Rigid> rigid_bodies;  // as World::rigid_bodies
};

[[nodiscard]] WorldState state_of(const bodies::World& world);

/// Pre: the state is of a world of the same bodies.
void set_state(bodies::World& world, const WorldState& state);

/// A state that has a name: what it is kept for.
struct NamedState {
  std::string name;
  WorldState state;
};

/// Writes `moment,time_s,body,node,x_m,...`, a row a node; a rigid body as node 0, with its
/// orientation and angular velocity. world: whose bodies they are. Throws std::runtime_error if the
/// file cannot be written.
void write_states(const std::filesystem::path& file, const bodies::World& world,
                  const std::vector<NamedState>& states);

/// Reads what write_states() wrote, to the bit. Throws std::runtime_error, one line, for what is no
/// such file or has other bodies or nodes than `world`.
[[nodiscard]] std::vector<NamedState> read_states(const std::filesystem::path& file,
                                                  const bodies::World& world);

}  // namespace stillgrid::laboratory
