#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/contacts/contact_rows.hpp"
#include "sim_server/dynamics/forces/explicit_state.hpp"

namespace stillgrid::dynamics {

/// How much impulse a change of the end velocity may ask for at most, N s per m/s; across the
/// normal while it sticks no more than it does.
struct ImpulseSlopes {
  double normal_kg = 0.0, across_kg = 0.0;
};

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// A body that contacts move. Velocities before its spin, impulses before their moments.
struct RigidMover {
  int rigid;
  double arm_m = 0.0;  // farthest contact
  Vector6 start, free, impulse, residual, direction;
  Eigen::Matrix3d inertia_kg_m2;  // world frame
  Matrix6 response;         // first what contacts ask for, kg, then the inverse with the masses
  double ratio = 0.0;       // of what they ask for to the masses
  bool is_widened = false;  // they ask for more than they did
};
/// A node that contacts move.
struct NodeMover {
  int node;
  Eigen::Vector3d start, free, residual, direction;
  Eigen::Matrix3d response;
  double ratio = 0.0;
  bool is_widened = false;
};

/// A sphere of nodes that touches.
struct SoftPoint {
  int node_count = 0;
  std::array<int, 4> nodes{}, movers{};  // movers: places of theirs; behind all: it does not move
  std::array<double, 4> weights{};
};

/// Bodies and nodes that touch one another, and their contacts, as ranges.
struct ContactIsland {
  struct Range {
    std::size_t first = 0, last = 0;  // last: behind it
  };
  Range touches, rows, rigid, nodes, soft;
};

/// How far an island is from the solution.
struct ContactResidual {
  double left_m_s = 0.0;    // what impulses ask for beyond the velocities, the largest
  double change_m_s = 0.0;  // of a velocity since the substep's start, the largest
  bool is_uphill = false;   // the last change went against what is left
};

/// What contacts move in a substep, island by island. All that it does in an island depends on that
/// island alone. Nothing is allocated once there was room.
class ContactMovers {
 public:
  /// Begins a substep in which nothing touches yet, of so many spheres.
  void clear(std::size_t spheres, const ExplicitState& state);
  /// Those of the sphere touch each other and `with` (-1: nobody). Returns one of all, -1: none.
  int enter(const bodies::SphereBinding& binding, int with, const ExplicitState& state);
  /// Divides what has entered by who touches whom. touched: of each touch one that it moves, or -1.
  /// Writes into place_of where each touch belongs so that islands are ranges.
  void divide(std::span<const int> touched, std::vector<std::size_t>& place_of);
  [[nodiscard]] std::span<ContactIsland> islands() noexcept { return islands_; }
  /// From here on point_of() is asked by contacts of the island, until of the next.
  void begin_island(std::size_t island);

  /// What moves the sphere of that number: a body or, of a sphere of nodes, itself; 0: contacts do
  /// not. Pre: divide() was told of it, and its island has begun.
  [[nodiscard]] int point_of(int sphere, const bodies::SphereBinding& binding,
                             const ExplicitState& state);
  /// Sum of what a velocity of the sphere is of its movers', 1 for a body; zero if none moves it.
  [[nodiscard]] static double weight_sum(const bodies::SphereBinding& binding,
                                         const ExplicitState& state);

  /// Velocities now are the substep's start.
  void note_start(const ExplicitState& state);
  /// A contact of a body's point has such an arm.
  void reach(int point, const Eigen::Vector3d& arm_m);
  /// Takes velocities that all but contacts have made, and leads all back to the substep's start.
  void start(ExplicitState& state);
  /// The fastest of an island without contacts, m/s.
  [[nodiscard]] double largest_m_s(const ContactIsland& island) const;

  /// How an island's points move.
  void place_points(const ContactIsland& island, const ExplicitState& state);
  [[nodiscard]] std::span<const ContactPoint> velocities() const noexcept { return velocities_; }
  /// What pushes an island's points: nothing yet.
  [[nodiscard]] std::span<ContactPoint> clear_impulses(const ContactIsland& island);
  /// What pushes points becomes the impulses of bodies and nodes.
  void gather_impulses(const ContactIsland& island);
  /// The responses of an island's movers are made anew: of all, or of those widened from here on.
  void begin_responses(const ContactIsland& island, bool all);
  /// A contact of the point asks for more than it did.
  void widen(int point);
  /// Adds what a contact asks for to the responses that are made anew.
  void add_slopes(int point, const Eigen::Vector3d& arm_m, const Eigen::Vector3d& normal,
                  const ImpulseSlopes& slopes, double weights);
  /// Makes each of those the inverse of its mass and of what contacts ask for at most. Returns the
  /// largest ratio of the second to the first, of all.
  double invert_responses(const ContactIsland& island, const ExplicitState& state);

  [[nodiscard]] ContactResidual residual(const ContactIsland& island, const ExplicitState& state);
  void advance(const ContactIsland& island, double momentum_weight, double residual_weight,
               ExplicitState& state);
  /// The impulses of all contacts on the velocities that all else made.
  void apply(ExplicitState& state) const;

 private:
  struct Entry {
    int index;  // of a rigid body, or of a node
    bool is_rigid;
  };
  int enter(Entry entry, int& number, int with);
  int root(int entry);
  [[nodiscard]] std::span<RigidMover> rigid_of(const ContactIsland& island);
  [[nodiscard]] std::span<NodeMover> nodes_of(const ContactIsland& island);

  std::vector<Entry> entries_;
  std::vector<int> parent_, island_of_;        // of each entry
  std::vector<int> rigid_mover_, node_mover_;  // of each: its entry, once divided its mover; or -1
  std::vector<ContactIsland> islands_;
  std::vector<SoftPoint> soft_;                 // their points are behind those of rigid bodies
  std::vector<PackedVector> node_impulse_N_s_;  // of each node's mover, and one for all others
  std::vector<ContactPoint> velocities_, impulses_;  // of points
  std::vector<int> point_of_;                        // of spheres of nodes, or 0
  std::size_t island_ = 0;                           // that has begun
  std::vector<RigidMover> rigid_movers_;
  std::vector<NodeMover> node_movers_;
};

}  // namespace stillgrid::dynamics
