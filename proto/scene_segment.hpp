#pragma once

#include "proto/distance_field.hpp"
#include "proto/segment_header.hpp"

namespace stillgrid::proto {

/// Snapshots of the scene that a slot holds: the current one and the one before it.
inline constexpr std::size_t kHistoryLength = 2;

inline constexpr std::uint32_t kMaxMaterials = 64;
inline constexpr std::uint32_t kMaxToolSpheres = 16;
inline constexpr std::uint32_t kMaxPlanes = 64;

inline constexpr std::size_t kMaxHands = 4;  // each hand has its own segments
inline constexpr std::size_t kHandNameBytes = 24;

/// Most levels of a grid. It has one level for each octave of the radii of its swept bounds.
inline constexpr std::uint32_t kMaxLevels = 8;

/// Material of a point of a body that has a field: the tool meets that field alone.
inline constexpr std::uint32_t kFieldPoint = 0xffffffff;

/// One sphere at one instant. World frame, SI units.
struct SphereState {
  std::array<float, 3> position_m;
  std::array<float, 3> velocity_m_s;
};

/// One collision sphere in both snapshots of the history: a cache line.
struct SphereRecord {
  SphereState newest, before;  // snapshots n and n - 1
  float radius_m;
  std::uint32_t material;  // index into SceneHeader::materials, or kFieldPoint
  std::uint32_t body;      // order in the scene file
  float crushing_force_N;  // a tool may crush the body by more; 0: no limit
};
static_assert(sizeof(SphereRecord) == 64);

/// A ball that holds a sphere wherever it may be shown while the grid stands: in both snapshots of
/// the history and on the way between them, with some room to move. World frame.
struct SweptBound {
  std::array<float, 3> centre_m;
  float bounding_radius_m;
};
static_assert(sizeof(SweptBound) == 16);

/// One level of the grid: voxels for the swept bounds of one octave of radius. A swept bound is
/// entered once, in the voxel of its centre; voxel (x, y, z) is stored in the cell (x, y, z) -
/// lowest_voxel, along an axis with fewer cells than voxels modulo the cells, which are a power of
/// two there.
struct GridLevel {
  std::array<std::int32_t, 3> lowest_voxel;  // of the swept bounds' centres
  float voxel_m;
  std::array<std::int32_t, 3> highest_voxel;  // likewise
  float bounding_radius_m;                    // the longest of the swept bounds entered here
  std::array<std::uint32_t, 3> cells;         // along each axis, 1 at least
  std::uint32_t first_cell;                   // cell (0, 0, 0) among the cells of all levels
};
static_assert(sizeof(GridLevel) == 48);

struct GridShape {
  std::uint32_t sphere_count;
  std::uint32_t level_count;
  std::array<GridLevel, kMaxLevels> levels;  // coarse to fine
};
static_assert(sizeof(GridShape) == 392);

/// Numbers of a static sphere in a touch list.
struct TouchLabel {
  std::uint32_t number;    // in the static grid
  std::uint32_t material;  // index into SceneHeader::materials
  std::uint32_t body;      // order in the scene file
  std::uint32_t reserved;
};
static_assert(sizeof(TouchLabel) == 16);

/// The touch lists: of each cell, the static spheres that a sphere of up to probe_radius_m touches
/// whose centre is there. At `offset` stand cell starts, u32, cell_count + 1 of them, to a multiple
/// of 64 bytes, then 32 bytes for each of entry_count entries. Cell c lists m = starts[c + 1] -
/// starts[c] of them, an even number, in the 32 m bytes from 32 starts[c] on: m times x, y, z and
/// radius, f32, in the world frame, then m TouchLabels. What fills a list up is nowhere: no number.
struct TouchShape {
  std::uint64_t offset;  // bytes from the segment's start
  std::uint32_t cell_count;
  std::uint32_t entry_count;
  float probe_radius_m;
  std::uint32_t level_count;
  std::array<GridLevel, kMaxLevels> levels;  // by octaves of radius and probe radius together
};
static_assert(sizeof(TouchShape) == 408);

struct Material {
  float stiffness_N_per_m;
  float damping_N_s_per_m;
  float friction;
  float slip_speed_m_s;
};

/// Solid below: points with normal . x < offset_m are inside.
struct Plane {
  std::array<float, 3> normal;  // unit
  float offset_m;
  std::uint32_t material;
  std::uint32_t body;
};

struct ToolSphere {
  std::array<float, 3> position_m;  // tool frame
  float radius_m;
};

/// Pose and scale of the device's frame in the scene: scene point = position + scale *
/// (orientation * device point).
struct DeviceFrame {
  std::array<double, 3> position_m;
  std::array<double, 4> orientation_xyzw;
  double scale;
};

/// The constant part of a scene. It follows SegmentHeader and is written once, before the magic.
/// The static grid's arrays begin at static_offset, in a slot's order: records, cell starts, swept
/// bounds, numbers. The numbers of the fields follow. Several bodies may share a field.
struct SceneHeader {
  std::array<char, 64> name;  // zero-terminated
  std::uint32_t material_count;
  std::uint32_t plane_count;
  std::uint32_t tool_sphere_count;
  std::uint32_t moving_capacity;  // spheres a slot holds room for
  std::uint32_t field_count;
  float
      tool_slip_speed_m_s;  // 0: the tool has proxies; else the penalty sum, friction viscous below
  std::uint64_t static_offset;  // bytes from the segment's start
  DeviceFrame device;
  GridShape static_grid;
  std::array<Material, kMaxMaterials> materials;
  std::array<Plane, kMaxPlanes> planes;
  std::array<ToolSphere, kMaxToolSpheres> tool;
  std::array<FieldBody, kMaxFields> fields;
  TouchShape touch_lists;
  std::uint64_t model_offset;    // bytes from the segment's start to the scene's model
  std::uint64_t model_bytes;     // 0: snapshots have no state
  std::uint64_t state_capacity;  // bytes that a slot has for a state, a multiple of 8
  std::uint32_t hand_count;      // hands in the session; 0: unknown
  std::uint32_t hand;            // number of this segment's
  // Names, zero-terminated; empty: the only hand.
  std::array<std::array<char, kHandNameBytes>, kMaxHands> hands;
};

/// Opens a slot's payload: one snapshot of what can move. Times are on the writer's clock. Behind
/// it stand the grid's arrays, a FieldRecord for each field that moves, and the state.
struct SnapshotHeader {
  std::uint64_t snapshot_id;
  std::uint64_t
      history_count;  // snapshots that exist, 1 to kHistoryLength; missing ones repeat the oldest
  std::array<std::uint64_t, kHistoryLength> state_time_ns;  // simulated time, newest first
  std::array<std::uint64_t, kHistoryLength>
      publish_time_ns;         // the instants T_n of the grid switches
  std::uint64_t tool_time_ns;  // of the tool sample that the newest snapshot contains, 0: none
  double tool_work_J;     // that the tool gave the scene from the segment's start up to that sample
  std::uint64_t step_ns;  // what the step cost, 0 in lockstep
  std::uint64_t contacts;  // in the simulation, for inspection
  // The state from which another process continues, behind all else in the slot.
  std::uint64_t state_bytes;  // 0: the snapshot is without
  std::uint64_t state_tick;   // the moment it belongs to: its number on the path of the tool
  std::uint64_t state_hash;   // positions and velocities: equal hashes, equal states
  GridShape grid;
};
static_assert(sizeof(SnapshotHeader) % 8 == 0);

inline constexpr std::uint64_t kSceneLayoutHash =
    layout_hash<33>({sizeof(SegmentHeader),
                     offsetof(SegmentHeader, latest),
                     offsetof(SegmentHeader, lockstep_sample_ns),
                     sizeof(SceneHeader),
                     offsetof(SceneHeader, materials),
                     offsetof(SceneHeader, planes),
                     offsetof(SceneHeader, tool),
                     sizeof(SnapshotHeader),
                     offsetof(SnapshotHeader, grid),
                     sizeof(SphereRecord),
                     offsetof(SphereRecord, crushing_force_N),
                     kHistoryLength,
                     offsetof(SnapshotHeader, tool_work_J),
                     sizeof(SweptBound),
                     sizeof(GridLevel),
                     offsetof(GridLevel, cells),
                     sizeof(GridShape),
                     offsetof(GridShape, levels),
                     kMaxLevels,
                     offsetof(SceneHeader, fields),
                     sizeof(FieldShape),
                     sizeof(FieldState),
                     sizeof(FieldBody),
                     sizeof(FieldRecord),
                     kMaxFields,
                     kBrickCells,
                     kBrickNodes,
                     offsetof(SceneHeader, touch_lists),
                     sizeof(TouchShape),
                     sizeof(TouchLabel),
                     offsetof(SceneHeader, model_offset),
                     offsetof(SnapshotHeader, state_bytes),
                     offsetof(SceneHeader, hand_count)});

}  // namespace stillgrid::proto
