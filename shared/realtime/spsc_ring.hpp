#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

namespace stillgrid::realtime {

/// A ring between one producer and one consumer thread. Room is allocated once.
///
/// The producer's release store of head_ publishes the item written before it to the consumer's
/// acquire load; tail_ likewise gives a slot back.
template <class T>
class SpscRing {
 public:
  /// capacity: rounded up to a power of two.
  explicit SpscRing(std::size_t capacity) {
    std::size_t size = 1;
    while (size < capacity) size *= 2;
    items_.resize(size);
  }

  /// False when full: the item is not taken. Thread: the producer's. Realtime: wait-free.
  bool push(const T& item) noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) == items_.size()) return false;
    items_[head & (items_.size() - 1)] = item;
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// False when empty. Thread: the consumer's.
  bool pop(T& item) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail == head_.load(std::memory_order_acquire)) return false;
    item = items_[tail & (items_.size() - 1)];
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

 private:
  std::vector<T> items_;
  alignas(64) std::atomic<std::size_t> head_ = 0;
  alignas(64) std::atomic<std::size_t> tail_ = 0;
};

}  // namespace stillgrid::realtime
