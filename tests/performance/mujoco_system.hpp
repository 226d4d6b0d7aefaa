#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <string>

namespace stillgrid::performance {

/// A model of MuJoCo's (2.2.2) and its state.
struct MujocoSystem {
  std::unique_ptr<mjModel, decltype(&mj_deleteModel)> model;
  std::unique_ptr<mjData, decltype(&mj_deleteData)> data;
};

/// Compiles a model's text and makes its state. Throws std::runtime_error with what MuJoCo said of
/// what it refuses.
[[nodiscard]] MujocoSystem load_mujoco(const std::string& text);

}  // namespace stillgrid::performance
