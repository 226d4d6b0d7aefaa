#include "tests/laboratory/world_state.hpp"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <ostream>

#include "shared/files/whole_file.hpp"
#include "tests/laboratory/csv_file.hpp"

namespace stillgrid::laboratory {
namespace {

constexpr const char* kColumns =
    "moment,time_s,body,node,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,qx,qy,qz,qw,wx_rad_s,wy_rad_s,"
    "wz_rad_s";
constexpr std::size_t kMoment = 0, kTime = 1, kBody = 2, kNode = 3, kPosition = 4, kVelocity = 7,
                      kOrientation = 10, kSpin = 14;
constexpr double kMax = 1e6;  // m, m/s or rad/s: what no scene has is somebody's slip

/// Calls what is given with each body's name, the number of the node within it, and where the state
/// has it: a node, or a rigid body.
template <class OfNode, class OfRigid>
void for_each_part(const bodies::World& world, const OfNode& of_node, const OfRigid& of_rigid) {
  for (const bodies::BodyRange& body : world.bodies) {
    for (int i = 0; i < body.node_count; ++i)
      of_node(body.name, i, static_cast<std::size_t>(body.first_node + i));
    if (body.rigid >= 0) of_rigid(body.name, 0, static_cast<std::size_t>(body.rigid));
  }
}

Eigen::Vector3d vector_at(const CsvFile& csv, std::size_t row, std::size_t column) {
  const auto number = [&](std::size_t at) { return csv.number(row, at, {-kMax, kMax}); };
  return {number(column), number(column + 1), number(column + 2)};
}

/// Reads the rows of one state from `row` on, and leaves that behind them.
class StateReader {
 public:
  StateReader(const CsvFile& csv, const bodies::World& world, std::size_t& row)
      : csv_(csv), world_(world), row_(row) {}

  [[nodiscard]] NamedState read() {
    NamedState named{.name = csv_.text(row_, kMoment), .state = state_of(world_)};
    WorldState& state = named.state;
    state.time_s = csv_.number(row_, kTime);
    for_each_part(
        world_,
        [&](const std::string& body, int node, std::size_t index) {
          take(named.name, body, node, state.nodes[index]);
          ++row_;
        },
        [&](const std::string& body, int node, std::size_t index) {
          WorldState::Rigid& rigid = state.rigid_bodies[index];
          take(named.name, body, node, rigid);
          rigid.orientation.coeffs() << vector_at(csv_, row_, kOrientation),
              csv_.number(row_, kOrientation + 3, {-kMax, kMax});
          if (!(std::abs(rigid.orientation.norm() - 1.0) < 1e-6))
            csv_.refuse(row_, csv_.text(row_, kOrientation), "a unit quaternion");
          rigid.angular_velocity_rad_s = vector_at(csv_, row_, kSpin);
          ++row_;
        });
    return named;
  }

 private:
  void take(const std::string& moment, const std::string& body, int node,
            WorldState::Point& point) {
    const std::string expected = "node " + std::to_string(node) + " of body '" + body +
                                 "' of the scene, at moment '" + moment + "'";
    if (row_ >= csv_.rows()) csv_.refuse(csv_.rows() - 1, "end of file", expected);
    if (csv_.text(row_, kMoment) != moment || csv_.text(row_, kBody) != body ||
        csv_.text(row_, kNode) != std::to_string(node))
      csv_.refuse(
          row_,
          csv_.text(row_, kMoment) + "," + csv_.text(row_, kBody) + "," + csv_.text(row_, kNode),
          expected);
    point.position_m = vector_at(csv_, row_, kPosition);
    point.velocity_m_s = vector_at(csv_, row_, kVelocity);
  }

  const CsvFile& csv_;
  const bodies::World& world_;
  std::size_t& row_;
};

}  // namespace

WorldState state_of(const bodies::World& world) {
  WorldState state{.time_s = world.time_s, .nodes = {}, .rigid_bodies = {}};
  for (const bodies::Node& node : world.nodes)
    state.nodes.push_back({.position_m = node.position_m, .velocity_m_s = node.velocity_m_s});
  for (const bodies::RigidBody& body : world.rigid_bodies) {
    WorldState::Rigid& rigid = state.rigid_bodies.emplace_back();
    rigid.position_m = body.position_m;
    rigid.velocity_m_s = body.velocity_m_s;
    rigid.orientation = body.orientation;
    rigid.angular_velocity_rad_s = body.angular_velocity_rad_s;
  }
  return state;
}

void set_state(bodies::World& world, const WorldState& state) {
  world.time_s = state.time_s;
  for (std::size_t i = 0; i < world.nodes.size(); ++i) {
    world.nodes[i].position_m = state.nodes[i].position_m;
    world.nodes[i].velocity_m_s = state.nodes[i].velocity_m_s;
  }
  for (std::size_t i = 0; i < world.rigid_bodies.size(); ++i) {
    bodies::RigidBody& body = world.rigid_bodies[i];
    const WorldState::Rigid& rigid = state.rigid_bodies[i];
    body.position_m = rigid.position_m;
    body.velocity_m_s = rigid.velocity_m_s;
    body.orientation = rigid.orientation;
    body.angular_velocity_rad_s = rigid.angular_velocity_rad_s;
  }
}

void write_states(const std::filesystem::path& file, const bodies::World& world,
                  const std::vector<NamedState>& states) {
  files::write_whole(file, [&](std::ostream& out) {
    out.precision(std::numeric_limits<double>::max_digits10);
    out << kColumns << '\n';
    const auto put = [&](const auto& values) {
      for (const double value : values) out << ',' << value;
    };
    const auto put_point = [&](const NamedState& named, const std::string& body, int node,
                               const WorldState::Point& point) {
      out << named.name << ',' << named.state.time_s << ',' << body << ',' << node;
      put(point.position_m);
      put(point.velocity_m_s);
    };
    for (const NamedState& named : states)
      for_each_part(
          world,
          [&](const std::string& body, int node, std::size_t index) {
            put_point(named, body, node, named.state.nodes[index]);
            out << ",0,0,0,1,0,0,0\n";
          },
          [&](const std::string& body, int node, std::size_t index) {
            const WorldState::Rigid& rigid = named.state.rigid_bodies[index];
            put_point(named, body, node, rigid);
            put(rigid.orientation.coeffs());
            put(rigid.angular_velocity_rad_s);
            out << '\n';
          });
  });
}

std::vector<NamedState> read_states(const std::filesystem::path& file, const bodies::World& world) {
  const CsvFile csv(file, kColumns);
  std::vector<NamedState> states;
  for (std::size_t row = 0; row < csv.rows();) {
    const std::size_t first = row;
    states.push_back(StateReader(csv, world, row).read());
    if (row == first)
      csv.refuse(row, csv.text(row, kBody), "no body: the scene has none that moves");
  }
  return states;
}

}  // namespace stillgrid::laboratory
