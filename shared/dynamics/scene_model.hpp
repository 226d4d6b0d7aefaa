#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "shared/dynamics/description.hpp"
#include "shared/dynamics/engine_method.hpp"
#include "shared/dynamics/scene_state.hpp"

namespace stillgrid::dynamics {

/// A motion that is known in advance: steady, and a sine along one direction.
struct PrescribedMotion {
  Eigen::Vector3d start_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  // of the sine, unit
  double amplitude_m = 0.0;
  double frequency_hz = 0.0;

  [[nodiscard]] Eigen::Vector3d position_m(double time_s) const;
};

/// All that two processes need to step the same scene: what each step depends on beside the state
/// and the tools' paths. Driven bodies are the prescribed ones, one that carries all that is static
/// if has_static_body, and one for each hand.
struct SceneModel {
  Description description;
  SceneState start;
  std::vector<PrescribedMotion> prescribed;
  bool has_static_body = false;
  std::size_t hands = 0;
  bool is_implicit = false;     // implicit Euler of the whole scene; else small steps
  double tolerance_m_s = 1e-8;  // of implicit Euler

  [[nodiscard]] EngineMethod method() const;
};

/// Returns the model as bytes; none for a model that has fields, which bytes do not hold.
[[nodiscard]] std::vector<std::byte> encode(const SceneModel& model);
/// Returns the model of encode()'s bytes, equal to the bit. Throws std::invalid_argument where a
/// count, an index or a number is not one of a sound model.
[[nodiscard]] SceneModel decode(std::span<const std::byte> bytes);

}  // namespace stillgrid::dynamics
