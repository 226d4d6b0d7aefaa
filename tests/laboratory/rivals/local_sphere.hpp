#pragma once

#include <array>
#include <optional>

#include "tests/laboratory/rivals/local_surface.hpp"

namespace stillgrid::laboratory {

/// A sphere for each sphere of the tool, fitted to the surface near it: through its nearest point,
/// with the normal there and the mean curvature round it [Balaniuk 1999]. Hollows count as flat.
class LocalSphere final : public LocalModel {
 public:
  void update(const LocalScene& scene, const PlacedTool& sampled, const PlacedTool& present,
              bool is_first) noexcept override;
  [[nodiscard]] rendering::ToolForce force(const LocalScene& scene,
                                           const PlacedTool& tool) noexcept override;

 private:
  struct Sphere {
    LocalSurface surface;
    Eigen::Vector3d centre_m;
    double contact_distance_m;  // its radius and the tool sphere's
  };
  std::array<std::optional<Sphere>, proto::kMaxToolSpheres> spheres_;
};

}  // namespace stillgrid::laboratory
