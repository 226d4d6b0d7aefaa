#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "proto/scene_segment.hpp"

namespace stillgrid::recording {

/// A collision sphere as it is shown. Scene frame.
struct SampledSphere {
  std::array<float, 3> centre_m;
  float radius_m;
  std::uint32_t body;  // order in the scene file

  bool operator==(const SampledSphere&) const = default;
};

struct SampledSpheres {
  std::vector<SampledSphere> spheres;
  std::uint64_t left_out = 0;  // of a scene that has more than are recorded
};

/// What never moves, and the tool's own spheres, in its frame.
struct FixedScene {
  SampledSpheres spheres;
  std::vector<proto::Plane> planes;
  std::vector<proto::ToolSphere> tool;
};

/// One snapshot as it is recorded.
struct SceneSample {
  std::uint64_t time_ns = 0;        // of its publication, on the writer's clock
  std::optional<FixedScene> fixed;  // of the first sample of a scene
  SampledSpheres moving;
};

}  // namespace stillgrid::recording
