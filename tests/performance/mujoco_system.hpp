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

/// Compiles a model's text and makes its state. The text may include "included.xml". Throws
/// std::runtime_error with MuJoCo's message where it refuses the model.
[[nodiscard]] MujocoSystem load_mujoco(const std::string& text, const std::string& included = {});

}  // namespace stillgrid::performance
