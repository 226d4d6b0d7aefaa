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
  std::size_t stride = 0;     // of rows of scratch
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

/// Rows of a sheet's scratch and constants, each with kLanes zeros before and room after it.
class SheetRows {
 public:
  static constexpr std::size_t kPositions = 0;                // three rows of x, y, z
  static constexpr std::size_t kVelocities = kPositions + 9;  // the same
  static constexpr std::size_t kForces = kVelocities + 9;     // for the node itself: three rows
  static constexpr std::size_t kNext = kForces + 9;           // for the next column's: two rows
  static constexpr std::size_t kAfterNext = kNext + 6;        // for the one after: one row
  static constexpr std::size_t kPulls = kAfterNext + 3;       // one row a kind
  static constexpr std::size_t kScratch = kPulls + kSpringKinds;
  static constexpr std::size_t kCount = kScratch + 3;

  explicit SheetRows(SpringSheet& sheet)
      : storage_(sheet.storage.front().lanes, contact::kLanes * sheet.storage.size()),
        stride_(sheet.stride) {}
  [[nodiscard]] contact::VectorRow<double> operator[](std::size_t row) const {
    return {storage_.data() + contact::kLanes + row * stride_, storage_};
  }
  /// A row that holds floats, half as long.
  [[nodiscard]] contact::VectorRow<float> floats(std::size_t row) const {
    auto* const first = reinterpret_cast<float*>(storage_.data() + contact::kLanes + row * stride_);
    return {first, {first, stride_}};
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
