#include "shared/tools/laboratory/lab_scenes.hpp"

#include <algorithm>
#include <charconv>

#include "sim_server/scene/scene_file.hpp"

namespace stillgrid::laboratory {
namespace {

constexpr double kPush_N = 1.0;
constexpr double kToolRadius_m = 0.005;

std::string text(double number) {
  std::array<char, 32> digits;
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), number);
  return {digits.data(), end};
}

std::string head(const LabScene& scene, double gravity_m_s2) {
  return "format = 2\n\n[world]\ngravity_m_s2 = [0.0, 0.0, " + text(gravity_m_s2) +
         "]\n\n[simulation]\nperiod_s = " + text(scene.period_s) +
         "\nsleeping = false\n\n[tool]\nradius_m = " + text(kToolRadius_m) +
         "\n\n[[material]]\nname = \"touched\"\ncontact_stiffness_N_per_m = " +
         text(scene.contact_stiffness_N_per_m) +
         "\ncontact_damping_N_s_per_m = " + text(scene.contact_damping_N_s_per_m) +
         "\nfriction = " + text(scene.friction) + "\n";
}

std::string wall() {
  return R"(
[[body]]
name = "wall"
kind = "plane"
point_m = [0.0, 0.0, -0.005]
normal = [0.0, 0.0, 1.0]
material = "touched"
)";
}

std::string free_body(const LabScene& scene) {
  return R"(
[[body]]
name = "free"
kind = "sphere"
position_m = [0.0, 0.0, -0.055]
radius_m = 0.05
material = "touched"
mass_kg = )" +
         text(scene.mass_kg) + "\n";
}

/// Eleven nodes share the mass, of which the last is pinned.
std::string chain(const LabScene& scene) {
  return R"(
[[body]]
name = "chain"
kind = "thread"
nodes = 11
from_m = [0.0, 0.0, -0.01]
to_m = [0.0, 0.0, -0.31]
pinned = "end"
spheres = { spacing_m = 0.03, radius_m = 0.005 }
material = "touched"
mass_kg = )" +
         text(11.0 * scene.mass_kg) +
         "\nspring_stiffness_N_per_m = { structural = " + text(scene.link_stiffness_N_per_m) +
         " }\n";
}

/// The tissue and a block of tissue_and_blocks.toml; the tool stands on the block's middle sphere.
std::string block(const LabScene& scene) {
  return R"(
[[material]]
name = "tissue"
contact_stiffness_N_per_m = 500.0
contact_damping_N_s_per_m = 1.0
friction = 0.3

[[body]]
name = "block"
kind = "rigid_box"
position_m = [0.0, 0.0, -0.015]
size_m = [0.03, 0.03, 0.02]
spheres = { spacing_m = 0.01, radius_m = 0.005 }
material = "touched"
mass_kg = )" +
         text(scene.mass_kg) +
         R"(

[[body]]
name = "tissue"
kind = "sheet"
position_m = [0.0, 0.0, -0.0315]
nodes = [8, 8]
size_m = [0.14, 0.14]
mass_kg = 0.128
spring_stiffness_N_per_m = { structural = 500.0, shear = 250.0, bend = 50.0 }
spring_damping_N_s_per_m = 0.2
spheres = { spacing_m = 0.01, radius_m = 0.0065 }
pinned = "corners"
material = "tissue"
)";
}

template <class Names>
std::optional<std::size_t> index_in(const Names& names, std::string_view name) {
  const auto* const found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<std::size_t>(found - names.begin());
}

}  // namespace

std::optional<LabBody> lab_body_named(std::string_view name) {
  const auto index = index_in(kLabBodyNames, name);
  if (!index) return std::nullopt;
  return static_cast<LabBody>(*index);
}

double usual_mass_kg(LabBody body) {
  constexpr std::array kMasses_kg = {0.1, 0.1, 0.01, 0.02};
  static_assert(kMasses_kg.size() == kLabBodyNames.size());
  return kMasses_kg[static_cast<std::size_t>(body)];
}

std::string scene_text(const LabScene& scene) {
  switch (scene.body) {
    case LabBody::kWall:
      break;
    case LabBody::kFree:
      return head(scene, kPush_N / scene.mass_kg) + free_body(scene);
    case LabBody::kChain:
      return head(scene, 0.0) + chain(scene);
    case LabBody::kBlock:
      return head(scene, 0.0) + block(scene);
  }
  return head(scene, 0.0) + wall();
}

scene::SceneDescription lab_scene(const LabScene& scene) {
  return scene::read_scene(scene_text(scene), std::string(name_of(scene.body)) + ".toml");
}

std::optional<LabHand> lab_hand_named(std::string_view name) {
  const auto index = index_in(kLabHandNames, name);
  if (!index) return std::nullopt;
  return static_cast<LabHand>(*index);
}

std::string device_text(LabHand hand, double resolution_m, double friction_N) {
  std::string device = "phantom:profile=premium15,path=still,centre_z_m=0,push_z_N=-1,";
  switch (hand) {
    case LabHand::kLight:
      device += "mass_kg=0.1,damping_N_s_per_m=5,hand=none,hand_stiffness_N_per_m=100";
      break;
    case LabHand::kHand:
      device += "mass_kg=0.1,damping_N_s_per_m=1,hand=measured";
      break;
    case LabHand::kNone:
      device += "mass_kg=0.1,damping_N_s_per_m=5,hand=none";
      break;
  }
  // Amplifiers without a limit: what is sought is where oscillations begin, not where they end.
  return device + ",max_force_N=1000,resolution_m=" + text(resolution_m) +
         ",friction_N=" + text(friction_N) + ",limits=0";
}

}  // namespace stillgrid::laboratory
