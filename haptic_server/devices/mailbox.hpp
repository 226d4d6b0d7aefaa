#pragma once

#include <array>
#include <atomic>
#include <type_traits>

namespace stillgrid::devices {

/// The newest value from one thread to one other: three slots, of which each side holds one and
/// the third changes hands. Realtime: wait-free on both sides.
template <class Value>
class Mailbox {
  static_assert(std::is_trivially_copyable_v<Value>);

 public:
  /// Thread: the one that puts.
  void put(const Value& value) noexcept {
    slots_[back_] = value;
    back_ = between_.exchange(back_ | kFresh, std::memory_order_acq_rel) & kSlot;
  }

  /// The newest, or a default-constructed one before any. Thread: the one that takes.
  [[nodiscard]] const Value& take() noexcept {
    if ((between_.load(std::memory_order_relaxed) & kFresh) != 0)
      front_ = between_.exchange(front_, std::memory_order_acq_rel) & kSlot;
    return slots_[front_];
  }

 private:
  static constexpr unsigned kSlot = 3, kFresh = 4;

  std::array<Value, 3> slots_{};
  unsigned back_ = 0, front_ = 1;
  std::atomic<unsigned> between_ = 2;
};

}  // namespace stillgrid::devices
