#include "tests/laboratory/lab_scenes.hpp"

#include <algorithm>
#include <charconv>

#include "sim_server/scene/scene_file.hpp"

namespace stillgrid::laboratory {
namespace {

constexpr double kPush_N = 1.0;
constexpr double kLink_N_per_m = 1000.0;
constexpr double kGravity_m_s2 = -9.81;

std::string text(double number) {
  std::array<char, 32> digits;
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), number);
  return {digits.data(), end};
}

struct ToolText {
  int spheres;
  std::string_view text;
};
ToolText tool_of(LabTool tool) {
  switch (tool) {
    case LabTool::kOne:
      break;
    case LabTool::kFour:
      return {4, R"(spheres = [
  { position_m = [0.004, 0.004, 0.0], radius_m = 0.005 },
  { position_m = [-0.004, 0.004, 0.0], radius_m = 0.005 },
  { position_m = [0.004, -0.004, 0.0], radius_m = 0.005 },
  { position_m = [-0.004, -0.004, 0.0], radius_m = 0.005 },
])"};
    case LabTool::kThree:
      return {3, R"(spheres = [
  { position_m = [-0.008, 0.0, 0.0], radius_m = 0.005 },
  { position_m = [0.0, 0.0, 0.0], radius_m = 0.005 },
  { position_m = [0.008, 0.0, 0.0], radius_m = 0.005 },
])"};
  }
  return {1, "radius_m = 0.005"};
}

std::string head(const LabScene& scene, double gravity_m_s2) {
  const auto [spheres, tool] = tool_of(scene.tool);
  return "format = 2\n\n[world]\ngravity_m_s2 = [0.0, 0.0, " + text(gravity_m_s2) +
         "]\n\n[simulation]\nperiod_s = " + text(scene.period_s) +
         "\nsleeping = false\n\n[tool]\n" + std::string(tool) +
         "\n\n[[material]]\nname = \"touched\"\ncontact_stiffness_N_per_m = " +
         text(scene.contact_stiffness_N_per_m / spheres) +
         "\ncontact_damping_N_s_per_m = " + text(scene.contact_damping_N_s_per_m / spheres) +
         "\nfriction = " + text(scene.friction) + "\n";
}

std::string body(std::string_view name, std::string_view kind, std::string_view keys) {
  return "\n[[body]]\nname = \"" + std::string(name) + "\"\nkind = \"" + std::string(kind) +
         "\"\nmaterial = \"touched\"" + std::string(keys);
}

std::string wall() {
  return body("wall", "plane", R"(
point_m = [0.0, 0.0, -0.005]
normal = [0.0, 0.0, 1.0]
)");
}

std::string ball(const LabScene& scene, std::string_view name, double z_m) {
  return body(name, "sphere",
              "\nposition_m = [0.0, 0.0, " + text(z_m) +
                  "]\nradius_m = 0.05\nmass_kg = " + text(scene.mass_kg) + "\n");
}

/// Nodes share the mass, of which the last, so far from the first, is pinned.
std::string links(const LabScene& scene, std::string_view name, int nodes, double from_m,
                  double length_m) {
  return body(name, "thread",
              "\nnodes = " + std::to_string(nodes) + "\nfrom_m = [0.0, 0.0, " + text(from_m) +
                  "]\nto_m = [0.0, 0.0, " + text(from_m + length_m) +
                  "]\npinned = \"end\"\nspheres = { spacing_m = 0.03, radius_m = 0.005 }\n"
                  "mass_kg = " +
                  text(nodes * scene.mass_kg) +
                  "\nspring_stiffness_N_per_m = { structural = " + text(kLink_N_per_m) + " }\n");
}

/// The tool stands on its middle sphere.
std::string rigid_block(const LabScene& scene) {
  return body("block", "rigid_box", R"(
position_m = [0.0, 0.0, -0.015]
size_m = [0.03, 0.03, 0.02]
spheres = { spacing_m = 0.01, radius_m = 0.005 }
mass_kg = )" + text(scene.mass_kg) + "\n");
}

/// That of tissue_and_blocks.toml, under a block of it.
constexpr std::string_view kTissue = R"(
[[material]]
name = "tissue"
contact_stiffness_N_per_m = 500.0
contact_damping_N_s_per_m = 1.0
friction = 0.3

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

constexpr std::string_view kGround = R"(
[[material]]
name = "ground"
contact_stiffness_N_per_m = 2000.0
contact_damping_N_s_per_m = 2.0
friction = 0.3

[[body]]
name = "floor"
kind = "plane"
point_m = [0.0, 0.0, -0.025]
normal = [0.0, 0.0, 1.0]
material = "ground"
)";

std::string soft_block(const LabScene& scene) {
  return body("soft", "soft_block", R"(
nodes = [4, 4, 3]
position_m = [0.0, 0.0, -0.015]
size_m = [0.03, 0.03, 0.02]
pinned = { low_m = [-0.1, -0.1, -0.1], high_m = [0.1, 0.1, -0.024] }
spheres = { spacing_m = 0.01, radius_m = 0.005 }
spring_stiffness_N_per_m = { structural = 500.0, shear = 250.0, bend = 50.0 }
spring_damping_N_s_per_m = 0.2
mass_kg = )" + text(scene.mass_kg) + "\n");
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
  constexpr std::array kMasses_kg = {0.1, 0.1, 0.1, 0.01, 5.0, 0.05, 0.02, 0.02, 0.05};
  static_assert(kMasses_kg.size() == kLabBodyNames.size());
  return kMasses_kg[static_cast<std::size_t>(body)];
}

double usual_friction(LabBody body) {
  return body == LabBody::kBlock || body == LabBody::kFloor ? 0.3 : 0.0;
}

std::optional<LabTool> lab_tool_named(std::string_view name) {
  const auto index = index_in(kLabToolNames, name);
  if (!index) return std::nullopt;
  return static_cast<LabTool>(*index);
}

std::string scene_text(const LabScene& scene) {
  switch (scene.body) {
    case LabBody::kWall:
      break;
    case LabBody::kFree:
      return head(scene, kPush_N / scene.mass_kg) + ball(scene, "free", -0.055);
    case LabBody::kRow:
      return head(scene, 0.5 * kPush_N / scene.mass_kg) + ball(scene, "near", -0.055) +
             ball(scene, "far", -0.155);
    case LabBody::kChain:
      return head(scene, 0.0) + links(scene, "chain", 11, -0.01, -0.3);
    case LabBody::kSpring:
      return head(scene, 0.0) + links(scene, "heavy", 2, -0.01, -0.03);
    case LabBody::kPinch:
      return head(scene, 0.0) + links(scene, "below", 2, -0.007, -0.03) +
             links(scene, "above", 2, 0.007, 0.03);
    case LabBody::kBlock:
      return head(scene, 0.0) + rigid_block(scene) + std::string(kTissue);
    case LabBody::kFloor:
      return head(scene, kGravity_m_s2) + rigid_block(scene) + std::string(kGround);
    case LabBody::kSoft:
      return head(scene, 0.0) + soft_block(scene);
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

HandModel model_of(LabHand hand) {
  switch (hand) {
    case LabHand::kLight:
      break;
    case LabHand::kHand:
      return {0.654, 7.45, 135.0};
    case LabHand::kNone:
      return {0.1, 5.0, 0.0};
  }
  return {0.1, 5.0, 100.0};
}

std::string device_text(LabHand hand, const LabDevice& device) {
  const HandModel model = model_of(hand);
  constexpr double kDevice_kg = 0.1, kStart_m = 0.01, kKick_m_s = -0.05;
  std::string words = "phantom:profile=premium15,path=still,centre_z_m=0,push_z_N=-1,hand=none";
  words += ",mass_kg=" + text(kDevice_kg) + ",hand_mass_kg=" + text(model.mass_kg - kDevice_kg) +
           ",damping_N_s_per_m=" + text(model.damping_N_s_per_m) +
           ",hand_stiffness_N_per_m=" + text(model.stiffness_N_per_m);
  words += ",hold_s=" + text(kHold_s);
  words +=
      device.starts_outside ? ",start_z_m=" + text(kStart_m) : ",velocity_z_m_s=" + text(kKick_m_s);
  if (device.declares_limits) return words;
  // Amplifiers without a limit: what is sought is where oscillations begin, not where they end.
  return words + ",max_force_N=1000,resolution_m=" + text(device.resolution_m) +
         ",friction_N=" + text(device.friction_N) + ",limits=0";
}

}  // namespace stillgrid::laboratory
