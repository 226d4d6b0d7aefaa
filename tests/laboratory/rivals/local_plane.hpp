#pragma once

#include <array>
#include <optional>

#include "tests/laboratory/rivals/local_surface.hpp"

namespace stillgrid::laboratory {

/// A plane for each sphere of the tool, tangent to what it touched or was near to, and its
/// recovery: where a new plane would suddenly press, it starts so that the press is the old one's,
/// and moves to its place over recovery_s [Mark 1996; ten cycles of 1 kHz in VRPN's
/// Plane::collisionDetect].
class LocalPlane final : public LocalModel {
 public:
  static constexpr double kRecovery_s = 0.010;

  explicit LocalPlane(double recovery_s = kRecovery_s) noexcept : recovery_s_(recovery_s) {}

  void update(const LocalScene& scene, const PlacedTool& sampled, const PlacedTool& present,
              bool is_first) noexcept override;
  [[nodiscard]] rendering::ToolForce force(const LocalScene& scene,
                                           const PlacedTool& tool) noexcept override;

 private:
  struct Plane {
    LocalSurface surface;
    Eigen::Vector3d fitted_at_m;  // of the tool sphere's centre
    double set_back_m = 0.0;      // at the update
  };
  [[nodiscard]] double depth_m(const Plane& plane, const rendering::PlacedToolSphere& probe,
                               std::uint64_t now_ns) const noexcept;

  double recovery_s_;
  std::uint64_t updated_ns_ = 0;
  std::array<std::optional<Plane>, proto::kMaxToolSpheres> planes_;
};

}  // namespace stillgrid::laboratory
