#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "proto/scene_segment.hpp"

namespace stillgrid {

/// Where a sphere is in image n - age of its history. Pre: age < kHistoryLength. Realtime: yes.
[[nodiscard]] inline const std::array<float, 3>& position_m(const proto::SphereRecord& record,
                                                            std::size_t age) noexcept {
  if (age == 0) return record.newest.position_m;
  return age <= record.older.size() ? record.older[age - 1].position_m : record.oldest_position_m;
}

/// The same image throughout, without drift or answer: of what stands still, and of a first image.
inline void fill_history(proto::SphereRecord& record, const proto::SphereImage& image) noexcept {
  record.newest = image;
  record.older = {image, image};
  record.oldest_position_m = image.position_m;
  record.drift_m_s = record.answer_m_N = {};
}

/// One more image; older ones move down. It drifts by its velocity, and does not answer.
inline void push_image(proto::SphereRecord& record, const proto::SphereImage& image) noexcept {
  record.oldest_position_m = record.older[1].position_m;
  record.older = {record.newest, record.older[0]};
  record.newest = image;
  record.drift_m_s = image.velocity_m_s;
  record.answer_m_N = {};
}

/// Weights of a history's images, newest first, told by the history of the image that came `later`
/// images after: those that it no longer holds count as its oldest. Realtime: yes.
template <std::size_t N>
[[nodiscard]] std::array<double, N> told_by_later(const std::array<double, N>& weights,
                                                  std::uint64_t later) noexcept {
  std::array<double, N> told{};
  for (std::size_t i = 0; i < N; ++i)
    told[i + std::min<std::uint64_t>(later, N - 1 - i)] += weights[i];
  return told;
}

}  // namespace stillgrid
