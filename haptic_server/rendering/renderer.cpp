#include "haptic_server/rendering/renderer.hpp"

#include <algorithm>
#include <cstddef>

#include "haptic_server/rendering/answer_renderer.hpp"
#include "haptic_server/rendering/local_model_renderer.hpp"
#include "haptic_server/rendering/models/crossfade.hpp"
#include "haptic_server/rendering/models/force_held.hpp"
#include "haptic_server/rendering/models/force_jacobian.hpp"
#include "haptic_server/rendering/models/local_plane.hpp"
#include "haptic_server/rendering/models/local_sphere.hpp"
#include "haptic_server/rendering/models/proxy.hpp"
#include "haptic_server/rendering/still_image.hpp"

namespace stillgrid {
namespace {

template <class Local>
std::unique_ptr<Renderer> local_renderer() {
  return std::make_unique<LocalModelRenderer>(std::make_unique<Local>());
}

}  // namespace

std::optional<Model> model_named(std::string_view name) {
  const auto* const found = std::find(kModelNames.begin(), kModelNames.end(), name);
  if (found == kModelNames.end()) return std::nullopt;
  return static_cast<Model>(found - kModelNames.begin());
}

std::string_view name_of(Model model) {
  return kModelNames[static_cast<std::size_t>(model)];
}

std::unique_ptr<Renderer> make_renderer(Model model, Transition transition) {
  switch (model) {
    case Model::kForceHeld:
      return local_renderer<ForceHeld>();
    case Model::kForceJacobian:
      return local_renderer<ForceJacobian>();
    case Model::kPlane:
      return local_renderer<LocalPlane>();
    case Model::kSphere:
      return local_renderer<LocalSphere>();
    case Model::kProxy:
      return local_renderer<Proxy>();
    case Model::kCrossfade:
      return std::make_unique<CrossfadeRenderer>();
    case Model::kGrid:
      break;
  }
  if (transition == Transition::kAnswer) return std::make_unique<AnswerRenderer>();
  return std::make_unique<StillImageRenderer>(transition);
}

}  // namespace stillgrid
