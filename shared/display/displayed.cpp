#include "shared/display/displayed.hpp"

namespace stillgrid {

DisplayedSphere displayed_where_present(const proto::SphereRecord& record,
                                        const ImageWeights& weights) noexcept {
  const std::array<proto::SphereImage, proto::kHistoryLength> images = {
      record.newest,
      record.older[0],
      record.older[1],
      {record.oldest_position_m, record.older[1].velocity_m_s}};
  DisplayedSphere sum{.presence = 0.0};
  for (std::size_t i = 0; i < images.size(); ++i) {
    // Hermite's weights leave [0, 1] a little; what is negative is not there.
    const double weight = std::max(0.0, weights.position[i]);
    if (detail::vector(images[i].position_m).hasNaN()) continue;
    detail::add(sum, images[i], weight, 0.0);
    sum.presence += weight;
  }
  sum.position_m /= sum.presence;
  sum.velocity_m_s /= sum.presence;
  sum.presence = std::min(1.0, sum.presence);
  return sum;
}

}  // namespace stillgrid
