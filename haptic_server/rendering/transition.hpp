#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "proto/scene_segment.hpp"

namespace stillgrid {

/// How the displayed scene passes from one still image to the next.
enum class Transition {
  kHold,    // the latest image as it is: jumps by v P at a switch
  kLinear,  // the paper's: from the image before to the latest over one period; lags by v P
};

/// The transition of that name (docs/formats.md), if there is one.
[[nodiscard]] std::optional<Transition> transition_named(std::string_view name);
[[nodiscard]] std::string_view name_of(Transition transition);

/// A displayed sphere is the sum of its images, each times its weight; weights sum to one and are
/// the same for every sphere. Velocities are blended alike.
struct ImageWeights {
  std::array<double, proto::kHistoryLength> weight{};  // newest first
  double alpha = 1.0;                                  // progress to the newest image
};

/// The weights at now_ns, on the clock of the snapshot's stamps.
///
/// Linear: a(t) = min((t - Tn) / (Tn - Tn-1), 1), the next switch being expected after a period
/// like the last [Davanne 2002, section 4; the print's max is a slip, its text fits only min].
/// Realtime: yes; bounded whatever the stamps say.
[[nodiscard]] ImageWeights image_weights(Transition transition,
                                         const proto::SnapshotHeader& snapshot,
                                         std::uint64_t now_ns) noexcept;

/// What would be displayed at now_ns had the newest image not come: the same transition on the
/// images before it. For the measure of a switch's jump.
[[nodiscard]] ImageWeights weights_before_switch(Transition transition,
                                                 const proto::SnapshotHeader& snapshot,
                                                 std::uint64_t now_ns) noexcept;

/// Weights that were of an image, told by the history of the one that came `later` images after it.
/// Images that history no longer holds count as its oldest. Realtime: yes.
[[nodiscard]] ImageWeights in_later_image(const ImageWeights& weights,
                                          std::uint64_t later) noexcept;

}  // namespace stillgrid
