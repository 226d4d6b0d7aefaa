#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>

#include "proto/scene_segment.hpp"
#include "shared/display/response.hpp"
#include "shared/rendering/tool_force.hpp"
#include "shared/rendering/touched_spheres.hpp"

namespace stillgrid::rendering {

/// Of a tool sphere's radius: no sphere gives way farther in a tick, for beyond its centre the tool
/// is on the other side, where a push draws.
inline constexpr double kMaxCompliantShift = 0.25;

/// The modes of a snapshot as a tick displays them.
struct ModeResponse {
  std::array<display::ModeLaw, proto::kMaxModes> laws{};
  display::ModeMotion motion = {};
  std::size_t count = 0;
  // Of modes that give way by steps: the step that ends now, in shares of the predicted one.
  std::array<display::ModeState, proto::kMaxModes> starts{};
  double from = 0.0, to = 0.0;
  std::uint64_t snapshot_id = 0;

  /// The laws of a snapshot, of a header as it was read, by these weights; displacements go along
  /// with what no push changes. Realtime: yes.
  void take(const proto::SnapshotHeader& snapshot,
            const display::SnapshotWeights& weights) noexcept;

  /// The displacements to which that push leads, the spheres' own; kept within a metre.
  /// Realtime: yes.
  void follow(const display::ModeDisplacements& push) noexcept;

 private:
  void take_step(const proto::SnapshotHeader& snapshot, const display::SnapshotWeights& weights,
                 double period_s) noexcept;
};

/// Places touched spheres where the modes move them. Realtime: yes.
void give_way(const display::ModeMotion& motion, TouchedSpheres& touched) noexcept;

class Pushes;

/// Lets touched spheres, which are displayed by the response's displacements, give way until the
/// forces on them are those to which they have given way.
///
/// Newton's method on what is the gradient of a convex energy but for normals that turn and for
/// friction; warm-started with the last tick's displacements, 12 evaluations at most. In one tick
/// no sphere moves farther than kMaxCompliantShift of the radius; what is left is the next tick's.
/// At a switch, which changes no force, in one iteration, of which there may be twice as many.
/// Thread: one; its memory is its own, that no tick allocates or first touches any.
class ResponseSolver {
 public:
  ResponseSolver();
  ~ResponseSolver();
  ResponseSolver(const ResponseSolver&) = delete;
  ResponseSolver& operator=(const ResponseSolver&) = delete;
  ResponseSolver(ResponseSolver&&) = delete;
  ResponseSolver& operator=(ResponseSolver&&) = delete;

  /// Returns what another iteration would change of the forces, N. Realtime: allocates nothing.
  [[nodiscard]] double solve(const proto::SceneHeader& scene,
                             std::span<const PlacedToolSphere> tool, const ToolPose& pose,
                             double radius_m, bool is_switch, TouchedSpheres& touched,
                             ModeResponse& response) noexcept;

 private:
  std::unique_ptr<Pushes> pushes_;
};

}  // namespace stillgrid::rendering
