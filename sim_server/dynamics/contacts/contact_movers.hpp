#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/dynamics/contacts/contact_rows.hpp"
#include "sim_server/dynamics/forces/explicit_state.hpp"
#include "sim_server/dynamics/workers/workers.hpp"

namespace stillgrid::dynamics {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// A body that contacts move. Velocities before its spin, impulses before their moments.
struct RigidMover {
  int rigid;
  double arm_m = 0.0;  // farthest contact
  double inverse_mass_per_kg = 0.0;
  Vector6 start, free, residual, direction;
  Eigen::Matrix3d inverse_inertia_per_kg_m2, inertia_kg_m2;  // world frame
};
/// A node that contacts move.
struct NodeMover {
  int node;
  Eigen::Vector3d start, free, residual, direction;
};

/// What contacts ask for at most, as multiples of masses, and of that the springs' share.
struct ResponseBound {
  double ratio = 0.0, spring_share = 0.0;

  void add(const ResponseBound& more) {
    ratio = std::max(ratio, more.ratio);
    spring_share = std::max(spring_share, more.spring_share);
  }
};

/// What contacts ask for, kg, then the inverse of that with the masses.
template <class Matrix>
struct Response {
  Matrix matrix;
  ResponseBound bound;
  bool is_widened = false;  // they ask for more than they did
};

/// Which lane of the rows pushes a point, and whether as the touch's second.
struct TouchSide {
  std::uint32_t lane;
  bool is_b;
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
  std::size_t first_chunk = 0;  // of its movers, rigid bodies before nodes
};

/// How far an island is from the solution.
struct ContactResidual {
  double left_m_s = 0.0;    // what impulses ask for beyond the velocities, the largest
  double change_m_s = 0.0;  // of a velocity since the substep's start, the largest
  double along_J = 0.0;     // of the last change with what is left; below zero: it led uphill

  void add(const ContactResidual& more);
};

/// Movers of an island that are summed over by themselves, whoever does it.
inline constexpr std::size_t kMoversAChunk = 256;

/// What contacts move in a substep, island by island. All that it does in an island depends on that
/// island alone. Nothing is allocated once there was room.
class ContactMovers {
 public:
  /// Begins a substep in which nothing touches yet, of so many spheres.
  void clear(std::size_t spheres, const ExplicitState& state);
  /// Those of the sphere touch each other and `with` (-1: nobody). Returns one of all, -1: none.
  int enter(const ContactSphere& sphere, int with, const ExplicitState& state);
  /// Divides what has entered by who touches whom. touched: of each touch one that it moves, or -1.
  /// Writes into place_of where each touch belongs so that islands are ranges.
  void divide(std::span<const int> touched, std::vector<std::size_t>& place_of);
  [[nodiscard]] std::span<ContactIsland> islands() noexcept { return islands_; }
  /// From here on point_of() is asked by contacts of the island, until of the next.
  void begin_island(std::size_t island);

  /// What moves the sphere at that place: a body or, of a sphere of nodes, itself; 0: contacts do
  /// not. Pre: divide() was told of it, and its island has begun.
  [[nodiscard]] int point_of(int place, const ContactSphere& sphere);
  /// Sum of what a velocity of the sphere is of its movers', 1 for a body; zero if none moves it.
  [[nodiscard]] static double weight_sum(const ContactSphere& sphere);

  /// Who pushes whom: of the rows of all islands.
  void note_sides(std::span<const ContactRows> rows);
  /// Velocities now are the substep's start.
  void note_start(const ExplicitState& state, const Workers& workers);
  /// How far from each body's centre its contacts are. Pre: the rows are placed.
  void reach(std::span<const ContactRows> rows, const Workers& workers);
  /// Takes velocities that all but contacts have made; points stay at the substep's start.
  void start(ExplicitState& state, const Workers& workers);
  /// The fastest of an island without contacts, m/s.
  [[nodiscard]] double largest_m_s(const ContactIsland& island) const;
  /// How points move in the iteration; of an island's nodes, as the state has them.
  [[nodiscard]] std::span<const ContactPoint> velocities() const noexcept { return velocities_; }
  void place_soft(const ContactIsland& island, const ExplicitState& state);

  /// The responses of an island's movers are made anew: of all, or of those that contacts ask more
  /// of. Returns the largest bounds of all.
  ResponseBound make_responses(const ContactIsland& island, std::span<const ContactRows> rows,
                               bool all, double substep_s, const ExplicitState& state,
                               const Workers& workers);

  /// How far the island is from where pushes lead.
  [[nodiscard]] ContactResidual residual(const ContactIsland& island,
                                         std::span<const ContactPush> pushes,
                                         const ExplicitState& state, const Workers& workers);
  void advance(const ContactIsland& island, double momentum_weight, double residual_weight,
               ExplicitState& state, const Workers& workers);
  /// The impulses of all contacts on the velocities that all else made, which points have then.
  void apply(ExplicitState& state, const Workers& workers);

 private:
  struct Entry {
    int index;  // of a rigid body, or of a node
    bool is_rigid;
  };
  int enter(Entry entry, int& number, int with);
  int root(int entry);
  [[nodiscard]] std::span<const TouchSide> sides_of(std::size_t point) const {
    return std::span(sides_).subspan(first_side_[point],
                                     first_side_[point + 1] - first_side_[point]);
  }
  [[nodiscard]] ContactPoint pushed(std::size_t point, std::span<const ContactPush> pushes) const;
  void push_nodes(const ContactIsland& island, std::span<const ContactPush> pushes);
  void widen(int point);
  void ask_body(std::size_t mover, std::span<const ContactRows> rows, double substep_s);
  double ask_nodes(const ContactIsland& island, std::span<const ContactRows> rows,
                   double substep_s);
  void ask_node(const SoftPoint& soft, const Eigen::Matrix3d& block);
  [[nodiscard]] ContactResidual body_residual(std::size_t mover,
                                              std::span<const ContactPush> pushes);
  [[nodiscard]] ContactResidual node_residual(std::size_t mover, const ExplicitState& state);

  std::vector<Entry> entries_;
  std::vector<int> parent_, island_of_;        // of each entry
  std::vector<int> rigid_mover_, node_mover_;  // of each: its entry, once divided its mover; or -1
  std::vector<ContactIsland> islands_;
  std::vector<SoftPoint> soft_;                 // their points are behind those of rigid bodies
  std::vector<PackedVector> node_impulse_N_s_;  // of each node's mover
  std::vector<ContactPoint> velocities_, impulses_;  // of points
  std::vector<int> point_of_;                        // of spheres of nodes, or 0
  std::size_t island_ = 0;                           // that has begun
  std::vector<std::uint32_t> first_side_;            // of each point, and one more
  std::vector<TouchSide> sides_;                     // point by point, in the order of lanes
  std::vector<RigidMover> rigid_movers_;
  std::vector<Response<Matrix6>> rigid_responses_;
  std::vector<NodeMover> node_movers_;
  std::vector<Response<Eigen::Matrix3d>> node_responses_;
  std::vector<ContactResidual> residuals_;  // of chunks of movers, island by island
  std::vector<ResponseBound> bounds_;       // likewise
};

}  // namespace stillgrid::dynamics
