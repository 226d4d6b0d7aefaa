#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::laboratory {

/// What the laboratory's tool presses on, from above along -z. The tool's spheres of 5 mm lie at
/// the height of the scene's origin and touch it there.
///
/// Contact is unilateral and lasts at equilibrium under the 1 N push of the laboratory's devices:
/// whatever is pressed is pressed back. So the linear analyses of the closed loop apply to small
/// motions, and loss of contact to large ones.
enum class LabBody {
  kWall,    // a still plane: the rigid wall
  kFree,    // a sphere without any other support, drawn up by a constant 1 N as if by gravity
  kRow,     // two of them in a row, drawn up by 1 N together
  kChain,   // ten masses on springs in line with the push, the last held by one more to a fixed
            // point
  kSpring,  // a heavy mass on one such spring
  kPinch,   // a mass on such a spring on either side of the tool, which they press by themselves
  kBlock,   // a rigid block between the tool and a tissue pinned at its corners, without gravity
  kFloor,   // a rigid block that gravity holds on a floor
  kSoft,    // a soft block pinned at its bottom
};
inline constexpr std::array<std::string_view, 9> kLabBodyNames = {
    "wall", "free", "row", "chain", "spring", "pinch", "block", "floor", "soft"};

[[nodiscard]] std::optional<LabBody> lab_body_named(std::string_view name);
[[nodiscard]] constexpr std::string_view name_of(LabBody body) {
  return kLabBodyNames[static_cast<std::size_t>(body)];
}

/// kg: of the free body 0.1, of each in the row 0.1, of a mass of the chain 0.01, of that on a
/// spring 5, of each that pinches 0.05, of the blocks 0.02, of the soft one 0.05.
[[nodiscard]] double usual_mass_kg(LabBody body);

/// Of the contact with the tool: 0.3 where a block would slide off, else none.
[[nodiscard]] double usual_friction(LabBody body);

/// Whether it is where it is without the tool, which can so come to it from outside.
[[nodiscard]] constexpr bool stands_alone(LabBody body) {
  return body != LabBody::kFree && body != LabBody::kRow && body != LabBody::kPinch;
}

/// The tool's spheres, in the plane across the push.
enum class LabTool { kOne, kFour, kThree };
inline constexpr std::array<std::string_view, 3> kLabToolNames = {"1x1", "2x2", "3x1"};

[[nodiscard]] std::optional<LabTool> lab_tool_named(std::string_view name);

/// What a map varies of a scene. Implicit Euler, solved by Newton, as the analyses assume.
struct LabScene {
  LabBody body = LabBody::kWall;
  LabTool tool = LabTool::kOne;
  double mass_kg = 0.1;                     // as of usual_mass_kg()
  double contact_stiffness_N_per_m = 1000;  // of the contact with all the tool's spheres
  double contact_damping_N_s_per_m = 0.0;
  double friction = 0.0;
  double period_s = 0.01;
};

/// The scene as a file would hold it (docs/formats.md), numbers that read back the same.
[[nodiscard]] std::string scene_text(const LabScene& scene);

/// The scene read from that text, named after its body.
[[nodiscard]] scene::SceneDescription lab_scene(const LabScene& scene);

/// Devices and hands of the analyses, each pushed by 1 N towards -z and held by its spring to the
/// origin: light, hand (a device of 0.1 kg and 1 N s/m in the measured hand [van Beek 2015]), and
/// none, as light but without a spring, which only a wall bears.
enum class LabHand { kLight, kHand, kNone };
inline constexpr std::array<std::string_view, 3> kLabHandNames = {"light", "hand", "none"};

[[nodiscard]] std::optional<LabHand> lab_hand_named(std::string_view name);

/// The device with what holds it.
struct HandModel {
  double mass_kg, damping_N_s_per_m, stiffness_N_per_m;
};
[[nodiscard]] HandModel model_of(LabHand hand);

/// What a cell's device is besides its hand.
struct LabDevice {
  bool declares_limits = false;  // those of the premium15, its force, friction and encoders too
  /// 10 mm above contact at rest, else in contact at 0.05 m/s into it.
  bool starts_outside = false;
  double resolution_m = 30e-6;  // of the encoders, where no limits are declared, as is
  double friction_N = 0.0;
};

/// How long the phantom is held at its start: until the safety chain's ramp is over, and what is in
/// contact is at rest there.
inline constexpr double kHold_s = 1.0;

/// The phantom of that hand, as --device takes it.
[[nodiscard]] std::string device_text(LabHand hand, const LabDevice& device);

}  // namespace stillgrid::laboratory
