#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "haptic_server/rendering/tool_force.hpp"
#include "haptic_server/rendering/transition.hpp"
#include "shared/publication/scene_segment.hpp"

namespace stillgrid {

/// What stands for the scene between two images.
enum class Model {
  kGrid,           // the whole still image, passing to the next by a transition: the paper's
  kForceHeld,      // the slow process's force
  kForceJacobian,  // that force with its derivatives by the tool's place and velocity
  kPlane,          // the tangent plane, with recovery
  kSphere,         // a sphere fitted to the surface near the tool
  kProxy,          // a god-object on the spheres near the tool
  kCrossfade,      // the forces of the last two images, one passing to the other
};

/// Names of models as --model takes them, in the order of the enumeration.
inline constexpr std::array<std::string_view, 7> kModelNames = {
    "grid", "force_held", "force_jacobian", "plane", "sphere", "proxy", "crossfade"};

[[nodiscard]] std::optional<Model> model_named(std::string_view name);
[[nodiscard]] std::string_view name_of(Model model);

/// What one tick rendered.
struct RenderedTick {
  ToolForce force;
  std::uint64_t generation = 0;  // of the image shown, 0: none yet
  bool is_new = false;           // the first tick that shows it
  double alpha = 1.0;            // progress of the transition to it
  bool stands = false;           // what is displayed waits for the next image
  double age_s = 0.0;            // of the simulated state shown newest
  double image_age_s = 0.0;      // since its publication
  bool contended = false;        // no fresh read: the last good sample was used
  bool cut = false;              // the tick's bound on work was met
  bool swept = false;            // a contact that was only on the way to this tick
  // At a switch: |force by the new image - force by the old one|, same place and time; what a model
  // adds so that the hand does not feel it (the rest of `answer`) is left out of both.
  std::optional<double> switch_jump_N;
  // Where its spheres were displayed; of a model that displays none, the image as it is.
  ImageWeights weights;
  double answer_N = 0.0;                              // times each sphere's answer
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  // of all
};

/// Computes the force of a scene on the tool, tick by tick, from its images alone.
///
/// Thread: the haptic loop's only. Neither copied nor moved.
class Renderer {
 public:
  Renderer() = default;
  virtual ~Renderer() = default;
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  Renderer(Renderer&&) = delete;
  Renderer& operator=(Renderer&&) = delete;

  /// The force on the tool at now_ns, on the clock of the scene's stamps. Where the latest image
  /// cannot be read the last good sample stands. Realtime: wait-free, allocates nothing.
  [[nodiscard]] virtual RenderedTick render(const SceneView& scene, const ToolPose& pose,
                                            std::uint64_t now_ns) noexcept = 0;
};

/// transition: of the model `grid`; the others have none.
[[nodiscard]] std::unique_ptr<Renderer> make_renderer(Model model, Transition transition);

}  // namespace stillgrid
