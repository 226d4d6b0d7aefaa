#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace stillgrid::contact {

/// Numbers of one look: what the widest vector of any target holds of doubles, to which all vectors
/// are capped; a multiple of every vector's lanes.
inline constexpr std::size_t kLanes = 8;

/// Whether a vector of kLanes numbers may be loaded from here as an aligned one, on every target.
template <class T>
[[nodiscard]] bool is_aligned_lanes(const T* place) noexcept {
  return reinterpret_cast<std::uintptr_t>(place) % (kLanes * sizeof(T)) == 0;
}

/// Numbers that vectors are loaded from and stored to, look after look.
///
/// In assertion builds each access is held against the widest vector of any target, whatever the
/// one that runs: the look that it is part of must lie in the storage and, where vectors are
/// aligned, at a multiple of its size. Otherwise a pointer and no more.
template <class T>
class VectorRow {
 public:
  VectorRow() = default;
  /// first: number 0, which need not be the storage's.
  VectorRow(T* first, [[maybe_unused]] std::span<T> storage) noexcept
      : first_(first)
#ifndef NDEBUG
        ,
        storage_(storage)
#endif
  {
  }
  /// A row that is read only.
  // NOLINTNEXTLINE(google-explicit-constructor): as a pointer becomes one to what is const
  operator VectorRow<const T>() const noexcept requires(!std::is_const_v<T>) {
#ifndef NDEBUG
    return {first_, storage_};
#else
    return {first_, {}};
#endif
  }

  /// The row that begins at number k of this one, or before it.
  [[nodiscard]] VectorRow operator+(std::ptrdiff_t k) const noexcept {
    VectorRow shifted = *this;
    shifted.first_ += k;
    return shifted;
  }

  /// Where a vector that begins with lane i is loaded or stored, unaligned; or several, of numbers
  /// that are interleaved. Pre: i is a multiple of the vector's lanes.
  [[nodiscard]] T* at(std::size_t i, std::size_t interleaved = 1) const noexcept {
    assert(holds_lanes(i, interleaved) && "the widest vector leaves its storage");
    return first_ + interleaved * i;
  }
  /// Number i alone.
  [[nodiscard]] T* one(std::size_t i) const noexcept {
    assert(first_ + i >= storage_.data() && first_ + i < storage_.data() + storage_.size());
    return first_ + i;
  }
  /// The same, aligned.
  [[nodiscard]] T* aligned(std::size_t i) const noexcept {
    assert(is_aligned_lanes(first_ + i / kLanes * kLanes) && "not aligned to the widest vector");
    return at(i);
  }

 private:
#ifndef NDEBUG
  [[nodiscard]] bool holds_lanes(std::size_t i, std::size_t interleaved) const noexcept {
    const T* const look = first_ + interleaved * (i / kLanes * kLanes);
    return look >= storage_.data() &&
           look + interleaved * kLanes <= storage_.data() + storage_.size();
  }
#endif

  T* first_ = nullptr;
#ifndef NDEBUG
  std::span<T> storage_;
#endif
};

}  // namespace stillgrid::contact
