#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/vector_row.hpp"
#include "sim_server/dynamics/forces/explicit_state.hpp"

namespace stillgrid::dynamics {

/// What the widest vector of any target loads at once, aligned so wherever it is copied.
struct alignas(contact::kLanes * sizeof(double)) Look {
  double lanes[contact::kLanes];
};
static_assert(sizeof(Look) == 64 && alignof(Look) == 64);
/// Of a regular sheet: along both axes, both diagonals, and past one node along both axes.
inline constexpr std::size_t kSpringKinds = 6;
/// Added to squares of lengths, so that none is zero, m2.
inline constexpr double kShortest_m2 = 1e-30;

/// What springs look at and what they pull at, from the world's first node on.
struct SpringNodes {
  const PackedVector *position_m, *velocity_m_s;
  PackedVector* force_N;
};

/// One of the kinds of springs of a sheet; zeros: none.
struct SpringKind {
  double stiffness_N_per_m = 0.0, rest_length_m = 0.0, damping_N_s_per_m = 0.0;
};

/// A body whose springs are a stencil over rows of nodes.
struct SpringSheet {
  std::size_t body = 0;
  std::size_t first_node = 0, columns = 0, rows = 0;
  std::array<SpringKind, kSpringKinds> kinds;
  bool damped = false;
  std::size_t stride = 0;     // of rows
  std::vector<Look> storage;  // they themselves: see SheetRows
};

/// Springs of one body in an order in which neighbours seldom share nodes.
struct SpringGroup {
  std::size_t body = 0;
  bool damped = false;
  std::vector<std::uint32_t> a, b;  // nodes; filled up to whole looks by springs of no stiffness
  std::vector<double> stiffness_N_per_m, push_N,
      damping_N_s_per_m;  // push: stiffness * rest length
};

/// Rows of a sheet's scratch and nodes, each with kLanes zeros before and room after it.
class SheetRows {
 public:
  static constexpr std::size_t kForces = 0;             // for the node itself: four rows of x, y, z
  static constexpr std::size_t kNext = kForces + 12;    // for the next column's: three rows
  static constexpr std::size_t kAfterNext = kNext + 9;  // for the one after: two rows
  static constexpr std::size_t kNodes = kAfterNext + 6;  // see of_nodes()
  /// Where a row of nodes begins: positions, velocities, each x, y, z, and inverse masses.
  static constexpr std::size_t of_nodes(std::size_t row) { return kNodes + 7 * row; }
  /// With two rows beyond the last, to which springs of no stiffness reach.
  static std::size_t count(std::size_t node_rows) { return of_nodes(node_rows + 2); }

  explicit SheetRows(SpringSheet& sheet)
      : storage_(sheet.storage.front().lanes, contact::kLanes * sheet.storage.size()),
        stride_(sheet.stride) {}
  [[nodiscard]] contact::VectorRow<double> operator[](std::size_t row) const {
    return {storage_.data() + contact::kLanes + row * stride_, storage_};
  }

 private:
  std::span<double> storage_;
  std::size_t stride_;
};

/// The body's springs as a sheet, if each kind is there everywhere or nowhere, and alike
/// everywhere.
[[nodiscard]] std::optional<SpringSheet> sheet_of(const bodies::World& world, std::size_t body);

/// The springs of any body.
[[nodiscard]] SpringGroup group_of(const bodies::World& world, std::size_t body);

}  // namespace stillgrid::dynamics
