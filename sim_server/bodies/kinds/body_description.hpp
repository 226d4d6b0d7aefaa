#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <span>
#include <string>
#include <variant>

#include "sim_server/bodies/kinds/compound.hpp"
#include "sim_server/bodies/kinds/mesh.hpp"
#include "sim_server/bodies/kinds/plane.hpp"
#include "sim_server/bodies/kinds/rigid_box.hpp"
#include "sim_server/bodies/kinds/sheet.hpp"
#include "sim_server/bodies/kinds/soft_block.hpp"
#include "sim_server/bodies/kinds/sphere.hpp"
#include "sim_server/bodies/kinds/thread.hpp"
#include "sim_server/bodies/motion.hpp"

namespace stillgrid::bodies {

/// What a body is, a struct a kind.
using BodyShape = std::variant<SphereBody, SheetBody, ThreadBody, SoftBlockBody, RigidBoxBody,
                               RigidMeshBody, SoftMeshBody, PlaneBody, CompoundBody>;

/// One [[body]] of a scene file: what bodies of every kind have, and its shape.
struct BodyDescription {
  std::string name;
  unsigned line = 0;  // of the scene file, where it begins
  Motion motion = Motion::kFree;
  PrescribedMotion prescribed;
  int material = 0;              // index into SceneDescription::materials
  double stiffness_scale = 1.0;  // of its contacts, stiffness and damping, against its material's
  double mass_kg = 0.0;          // of the whole body; a free body has one

  // Its frame; a thread stands where its ends are.
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();

  BodyShape shape;
};

/// The springs of a body that is made of masses and springs; none: it is rigid.
[[nodiscard]] inline const SpringDescription* springs_of(const BodyDescription& body) {
  return std::visit(
      [](const auto& shape) -> const SpringDescription* {
        if constexpr (requires { shape.springs; }) return &shape.springs;
        return nullptr;
      },
      body.shape);
}
[[nodiscard]] inline bool is_deformable(const BodyDescription& body) {
  return springs_of(body) != nullptr;
}

/// The balls that a mesh was made into; none of other kinds.
[[nodiscard]] inline std::span<const spheres::Ball> balls_of(const BodyDescription& body) {
  return std::visit(
      [](const auto& shape) -> std::span<const spheres::Ball> {
        if constexpr (requires { shape.balls; }) return shape.balls;
        return {};
      },
      body.shape);
}
/// The distance field that a mesh is met through; null: it has none.
[[nodiscard]] inline std::shared_ptr<const collision::DistanceField> field_of(
    const BodyDescription& body) {
  const auto* const mesh = std::get_if<RigidMeshBody>(&body.shape);
  return mesh != nullptr ? mesh->field : nullptr;
}
/// The lattice of a soft solid; null of other kinds.
[[nodiscard]] inline const SoftLattice* lattice_of(const BodyDescription& body) {
  return std::visit(
      [](const auto& shape) -> const SoftLattice* {
        if constexpr (requires { shape.lattice; }) return &shape.lattice;
        return nullptr;
      },
      body.shape);
}

}  // namespace stillgrid::bodies
