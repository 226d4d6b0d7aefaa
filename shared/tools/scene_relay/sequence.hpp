#pragma once

#include <span>
#include <type_traits>
#include <vector>

namespace stillgrid::scene_relay {

/// The elements of a message's sequence.
template <class Sequence>
[[nodiscard]] auto elements(const Sequence& sequence) noexcept {
  using Element = std::remove_pointer_t<decltype(sequence._buffer)>;
  return std::span<const Element>(sequence._buffer,
                                  sequence._buffer != nullptr ? sequence._length : 0U);
}

/// Lets a message's sequence tell of elements that stand elsewhere, for as long as they do.
template <class Sequence, class Element>
void point_to(Sequence& sequence, std::vector<Element>& own) noexcept {
  sequence._maximum = sequence._length = static_cast<std::uint32_t>(own.size());
  sequence._buffer = own.data();
  sequence._release = false;
}

}  // namespace stillgrid::scene_relay
