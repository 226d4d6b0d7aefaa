#pragma once

#include "tests/laboratory/rivals/local_model.hpp"

namespace stillgrid::laboratory {

/// The slow process's force, held: no model at all, and what every model is there to beat. Where a
/// step costs nothing it is CHAI3D's one loop, in which a force is computed, bodies are advanced by
/// it and it is sent, once a step [modules/GEL/examples/GLFW/01-GEL-membrane, updateHaptics()];
/// there bodies advance explicitly, and steps are cut to a millisecond.
class ForceHeld final : public LocalModel {
 public:
  void update(const LocalScene& scene, const PlacedTool& sampled, const PlacedTool&,
              bool) noexcept override {
    force_ = rendering::tool_force(scene.fixed, scene.patch, sampled.spheres, sampled.pose);
  }
  [[nodiscard]] rendering::ToolForce force(const LocalScene&, const PlacedTool&) noexcept override {
    return force_;
  }

 private:
  rendering::ToolForce force_;
};

}  // namespace stillgrid::laboratory
