#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "proto/stillgrid.hpp"
#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::library {

inline constexpr std::uint32_t kMoving = 3;

/// The fixed part of a scene: two materials, a plane, two static spheres, a hand of two spheres.
struct Fixture {
  publication::TestSession session;
  std::array<stillgrid_material, 2> materials{{{500.0, 1.0, 0.25}, {2000.0, 4.0, 0.5}}};
  stillgrid_plane plane{{0.0, 0.0, 1.0}, -0.5, 1, 5};
  std::array<double, 8> tool_m{0.0, 0.0, 0.0, 0.25, 0.0, 0.0, 0.5, 0.125};
  std::array<double, 2> static_radii_m{0.5, 0.25};
  std::array<std::uint32_t, 2> static_materials{1, 0}, static_bodies{6, 7};
  std::array<double, 6> static_positions_m{1.0, 0.0, -1.0, 2.0, 0.0, -1.0};
  Shapes static_shapes{static_radii_m, static_materials, static_bodies, static_positions_m};
  Hand hand;
  Scene scene;

  Fixture() {
    hand.tool_count = 2;
    hand.tool_m = tool_m.data();
    hand.device_position_m[2] = 0.5;
    hand.device_scale = 2.0;
    scene.session = session.name().c_str();
    scene.name = "three spheres";
    scene.period_s = 0.03;
    scene.sphere_capacity = kMoving;
    scene.material_count = 2;
    scene.materials = materials.data();
    scene.plane_count = 1;
    scene.planes = &plane;
    scene.hand_count = 1;
    scene.hands = &hand;
    scene.static_shapes = &static_shapes;
  }
  Fixture(const Fixture&) = delete;
  Fixture& operator=(const Fixture&) = delete;
};

inline constexpr std::array<double, kMoving> kRadii_m{0.5, 0.25, 0.125};
inline constexpr std::array<std::uint32_t, kMoving> kMaterials{0, 1, 0}, kBodies{1, 1, 2};

/// Returns the places of the spheres in state n, as numbers that a float holds.
inline std::vector<double> positions_m(int n) {
  return {0.0, 0.25 * n, 0.0, 1.0, 0.25 * n, 0.0, 2.0, 0.25 * n, 0.0};
}
inline const std::vector<double> kVelocities_m_s{0.0, 8.0, 0.0, 0.0, 8.0, 0.0, 0.0, 8.0, 0.0};

/// Declares the three spheres.
inline void declare(Publisher& publisher) {
  publisher.set_shapes(Shapes(kRadii_m, kMaterials, kBodies));
}
inline void publish(Publisher& publisher, int n) {
  publisher.set_spheres(positions_m(n), kVelocities_m_s);
  publisher.publish();
}

/// The code of an Error that a call throws; STILLGRID_OK where it does not.
template <class Call>
int code_of(Call&& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.code();
  }
  return STILLGRID_OK;
}

}  // namespace stillgrid::library
