#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace stillgrid::proto {

/// Bodies of a scene that are felt through distance fields.
inline constexpr std::uint32_t kMaxFields = 512;

/// Cells of a fine brick along each of its edges, and coefficients, which reach a cell farther.
inline constexpr std::uint32_t kBrickCells = 4;
inline constexpr std::uint32_t kBrickNodes = kBrickCells + 2;
inline constexpr std::uint32_t kBrickCoefficients = kBrickNodes * kBrickNodes * kBrickNodes;

/// Source of a field's distance: samples, or a closed form centred in its frame.
enum class FieldKind : std::uint32_t {
  kSampled,   // coefficients in bricks
  kBox,       // sides along the axes
  kCapsule,   // along z, round ends included
  kCylinder,  // along z
};
inline constexpr std::uint32_t kFieldKinds = 4;

/// Header of a distance field and the layout of its numbers. Body frame, SI units.
///
/// A closed form has no numbers. `lowest_m` is minus half of its sides. `bounding_radius_m` is
/// that of a ball around it. Every other member except `kind` is zero. The x and y sides of a
/// capsule or cylinder are equal, and the z side of a capsule is not shorter.
///
/// Sampled numbers: behind `offset`, each array at a multiple of 8 bytes: coarse coefficients,
/// f32, one a brick and a layer more on every side, x fastest; `bricks` u32, the number of each
/// brick's fine coefficients, from 1, 0: none; stiffness, f32, as the coarse ones, if
/// has_stiffness; fine coefficients, f32, kBrickCoefficients a number.
struct FieldShape {
  std::array<float, 3> lowest_m;  // corner of the first brick
  float brick_m;                  // a brick's edge
  std::array<std::uint32_t, 3> bricks;
  std::uint32_t fine_count;
  std::array<float, 3> centre_m;  // of a ball that holds the solid
  float bounding_radius_m;
  std::uint32_t has_stiffness;  // 1: a map of stiffness over the material's; 0: none
  std::uint32_t kind;           // FieldKind
};
static_assert(sizeof(FieldShape) == 56);

/// Pose and velocity of a body that has a field. World frame.
struct FieldState {
  std::array<float, 3> position_m;        // of the body frame's origin
  std::array<float, 4> orientation_xyzw;  // unit, world from body
  std::array<float, 3> velocity_m_s;
  std::array<float, 3> angular_velocity_rad_s;
  float reserved;
};
static_assert(sizeof(FieldState) == 56);

/// A body that is felt through a field: written once.
struct FieldBody {
  FieldShape shape;
  std::uint64_t offset;  // bytes from the segment's start to the field's numbers
  FieldState rest;       // of one that never moves
  std::uint32_t moving;  // its FieldRecord in a snapshot, from 1; 0: it never moves
  std::uint32_t material;
  std::uint32_t body;  // order in the scene file
  std::uint32_t reserved;
};
static_assert(sizeof(FieldBody) == 136);

/// One moving body with a field in both snapshots of the history, as SphereRecord is of a sphere.
struct FieldRecord {
  std::array<FieldState, 2> history;  // newest first
};
static_assert(sizeof(FieldRecord) == 112);

}  // namespace stillgrid::proto
