#include "sim_server/scene/build_world.hpp"

#include "sim_server/bodies/kinds/body_in_world.hpp"
#include "sim_server/scene/build_joints.hpp"

namespace stillgrid::scene {

bodies::World build_world(const SceneDescription& scene) {
  bodies::World world;
  world.gravity_m_s2 = scene.gravity_m_s2;
  for (const MaterialDescription& material : scene.materials)
    world.materials.push_back({material.contact_stiffness_N_per_m,
                               material.contact_damping_N_s_per_m, material.friction,
                               material.slip_speed_m_s});
  for (const bodies::BodyDescription& body : scene.bodies) bodies::add_body(world, body);
  build_joints(scene.joints, world);
  return world;
}

}  // namespace stillgrid::scene
