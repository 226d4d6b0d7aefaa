#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::laboratory {

/// What the laboratory's tool presses on, from above along -z. The tool, a sphere of 5 mm, starts
/// at the scene's origin and touches it there.
///
/// Contact is unilateral and lasts at equilibrium under the 1 N push of the laboratory's devices:
/// whatever is pressed is pressed back. So the linear analyses of the closed loop apply to small
/// motions, and loss of contact to large ones.
enum class LabBody {
  kWall,   // a still plane: the rigid wall
  kFree,   // a sphere without any other support, drawn up by a constant 1 N as if by gravity
  kChain,  // ten masses on springs in line with the push, the last held by one more to a fixed
           // point
  kBlock,  // a rigid block between the tool and a tissue pinned at its corners, without gravity
};
inline constexpr std::array<std::string_view, 4> kLabBodyNames = {"wall", "free", "chain", "block"};

[[nodiscard]] std::optional<LabBody> lab_body_named(std::string_view name);
[[nodiscard]] constexpr std::string_view name_of(LabBody body) {
  return kLabBodyNames[static_cast<std::size_t>(body)];
}

/// Of the free body 0.1 kg, of a mass of the chain 0.01 kg, of the block 0.02 kg.
[[nodiscard]] double usual_mass_kg(LabBody body);

/// What a map varies of a scene. Implicit Euler, solved by Newton, as the analyses assume.
struct LabScene {
  LabBody body = LabBody::kWall;
  double mass_kg = 0.1;                     // of the free body, a mass of the chain, or the block
  double link_stiffness_N_per_m = 1000.0;   // of the chain
  double contact_stiffness_N_per_m = 1000;  // of the contact with the tool
  double contact_damping_N_s_per_m = 0.0;
  double friction = 0.0;
  double period_s = 0.01;
};

/// The scene as a file would hold it (docs/formats.md), numbers that read back the same.
[[nodiscard]] std::string scene_text(const LabScene& scene);

/// The scene read from that text, named after its body.
[[nodiscard]] scene::SceneDescription lab_scene(const LabScene& scene);

/// Devices and hands of the analyses, each pushed by 1 N towards -z and held by its spring to the
/// origin. Total mass, damping and stiffness: light 0.1 kg, 5 N s/m, 100 N/m; hand (a device of 0.1
/// kg and 1 N s/m in the measured hand) 0.654 kg, 7.45 N s/m, 135 N/m; free as light, without a
/// spring, which only a wall bears.
enum class LabHand { kLight, kHand, kNone };
inline constexpr std::array<std::string_view, 3> kLabHandNames = {"light", "hand", "none"};

[[nodiscard]] std::optional<LabHand> lab_hand_named(std::string_view name);

/// The phantom of that hand, as --device takes it. resolution_m: of its encoders.
[[nodiscard]] std::string device_text(LabHand hand, double resolution_m, double friction_N);

}  // namespace stillgrid::laboratory
