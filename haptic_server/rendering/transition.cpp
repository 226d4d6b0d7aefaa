#include "haptic_server/rendering/transition.hpp"

#include <algorithm>
#include <cstddef>

namespace stillgrid {
namespace {

/// The transition to the image numbered `newest` in the history.
ImageWeights weights_from(Transition transition, const proto::SnapshotHeader& snapshot,
                          std::size_t newest, std::uint64_t now_ns) noexcept {
  ImageWeights weights;
  const std::uint64_t switch_ns = snapshot.publish_time_ns[newest];
  const std::uint64_t before_ns = snapshot.publish_time_ns[newest + 1];
  const bool has_before = snapshot.history_count > newest + 1 && before_ns < switch_ns;
  if (transition == Transition::kLinear && has_before &&
      now_ns < switch_ns + (switch_ns - before_ns))
    weights.alpha = now_ns <= switch_ns ? 0.0
                                        : static_cast<double>(now_ns - switch_ns) /
                                              static_cast<double>(switch_ns - before_ns);
  weights.weight[newest] = weights.alpha;
  weights.weight[newest + 1] = 1.0 - weights.alpha;
  return weights;
}

}  // namespace

std::optional<Transition> transition_named(std::string_view name) {
  if (name == "hold") return Transition::kHold;
  if (name == "linear") return Transition::kLinear;
  return std::nullopt;
}

std::string_view name_of(Transition transition) {
  return transition == Transition::kHold ? "hold" : "linear";
}

ImageWeights image_weights(Transition transition, const proto::SnapshotHeader& snapshot,
                           std::uint64_t now_ns) noexcept {
  return weights_from(transition, snapshot, 0, now_ns);
}

ImageWeights weights_before_switch(Transition transition, const proto::SnapshotHeader& snapshot,
                                   std::uint64_t now_ns) noexcept {
  return weights_from(transition, snapshot, 1, now_ns);
}

ImageWeights in_later_image(const ImageWeights& weights, std::uint64_t later) noexcept {
  if (later == 0) return weights;
  constexpr std::size_t kOldest = proto::kHistoryLength - 1;
  ImageWeights shifted;
  shifted.alpha = weights.alpha;
  for (std::size_t i = 0; i <= kOldest; ++i)
    shifted.weight[i + std::min<std::uint64_t>(later, kOldest - i)] += weights.weight[i];
  return shifted;
}

}  // namespace stillgrid
