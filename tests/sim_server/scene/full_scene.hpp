#pragma once

#include <string_view>

namespace stillgrid::scene {

/// A scene with every section, kind and motion.
inline constexpr std::string_view kFullScene = R"(format = 2
[world]
gravity_m_s2 = [0.0, -1.5, 0]
[simulation]
period_s = 0.02
integrator = "implicit_euler"
[grid]
voxel_ratio = 1.25
[tool]
spheres = [{ radius_m = 0.004 }, { position_m = [0.0, 0.0, 0.01], radius_m = 0.003 }]
[device]
position_m = [0.1, 0.2, 0.3]
orientation_xyzw = [0.0, 0.0, 0.7071, 0.7071]
scale = 2.0
[[material]]
name = "soft"
contact_stiffness_N_per_m = 300
[[material]]
name = "hard"
contact_stiffness_N_per_m = 900.0
contact_damping_N_s_per_m = 2.0
friction = 0.4
slip_speed_m_s = 0.005
[[body]]
name = "cloth"
kind = "sheet"
nodes = [3, 4]
position_m = [0.0, 0.0, 0.1]
size_m = [0.2, 0.3]
mass_kg = 0.12
spring_stiffness_N_per_m = { structural = 50.0, shear = 20.0, bend = 5.0 }
spring_damping_N_s_per_m = 0.1
spring_rest_ratio = 0.9
spheres = { spacing_m = 0.02, radius_m = 0.015 }
velocity_m_s = [0.0, 0.0, 1.0]
pinned = "two_corners"
material = "soft"
[[body]]
name = "thread"
kind = "thread"
nodes = 5
from_m = [0.0, 0.0, 0.4]
to_m = [0.0, 0.0, 0.2]
mass_kg = 0.01
spring_stiffness_N_per_m = { structural = 10.0 }
pinned = [4, 0, 4]
material = "soft"
[[body]]
name = "sponge"
kind = "soft_block"
nodes = [3, 2, 4]
position_m = [2.0, 0.0, 0.0]
size_m = [0.2, 0.1, 0.3]
mass_kg = 0.24
spring_stiffness_N_per_m = { structural = 80.0, shear = 40.0 }
spheres = { spacing_m = 0.04, radius_m = 0.02 }
pinned = { low_m = [-9, -9, -9], high_m = [9, 9, -0.1] }
material = "soft"
[[body]]
name = "box"
kind = "rigid_box"
position_m = [0.5, 0.0, 0.0]
size_m = [0.1, 0.2, 0.3]
mass_kg = 0.5
angular_velocity_rad_s = [1.0, 0.0, 0.0]
material = "hard"
[[body]]
name = "shaker"
kind = "sphere"
motion = "prescribed"
direction = [0.0, 0.0, 2.0]
amplitude_m = 0.01
frequency_hz = 2.0
position_m = [0.0, 1.0, 0.0]
radius_m = 0.05
material = "hard"
[[body]]
name = "runner"
kind = "rigid_box"
motion = "prescribed"
velocity_m_s = [-0.1, 0.0, 0.2]
size_m = [0.1, 0.1, 0.1]
material = "hard"
[[body]]
name = "floor"
kind = "plane"
point_m = [0.0, 0.0, -1.0]
normal = [0.0, 3.0, 4.0]
material = "hard"
[[body]]
name = "hammer"
kind = "compound"
position_m = [0.0, 2.0, 0.0]
mass_kg = 0.3
material = "hard"
[[body.shape]]
kind = "box"
size_m = [0.03, 0.03, 0.08]
orientation_xyzw = [0.0, 0.6, 0.0, 0.8]
[[body.shape]]
kind = "cylinder"
radius_m = 0.01
length_m = 0.2
position_m = [0.0, 0.0, -0.1]
[[joint]]
name = "hinge"
body = "box"
joined_to = "runner"
points_m = [[0.5, -0.1, 0.0], [0.5, 0.1, 0.0]]
stiffness_N_per_m = 300.0
damping_N_s_per_m = 0.4
collide = true
)";

}  // namespace stillgrid::scene
