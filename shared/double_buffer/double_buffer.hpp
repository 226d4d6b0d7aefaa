#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <type_traits>

#include "proto/segment_header.hpp"

namespace stillgrid::double_buffer {

/// The machine's own atomics. The protocol below is written over such a policy, so that a checker
/// can run the same lines over a model of relaxed memory.
///
/// Loads are plain loads of 8 bytes: on a read-only page a compare-and-swap or a wider load faults.
struct HardwareAtomics {
  static std::uint64_t load(const std::uint64_t& word, std::memory_order order) noexcept {
    // atomic_ref wants a mutable object although load() does not write it.
    return std::atomic_ref(const_cast<std::uint64_t&>(word)).load(order);  // NOLINT
  }
  static void store(std::uint64_t& word, std::uint64_t value, std::memory_order order) noexcept {
    std::atomic_ref(word).store(value, order);
  }
  static void fence(std::memory_order order) noexcept { std::atomic_thread_fence(order); }
};
static_assert(std::atomic_ref<std::uint64_t>::is_always_lock_free);

/// The words that writer and readers share: see docs/protocol.md, "Publication".
struct DoubleBuffer {
  std::uint64_t* latest = nullptr;
  std::uint64_t* sequence[2] = {nullptr, nullptr};
  std::uint64_t* payload[2] = {nullptr, nullptr};
};

/// A run of payload words, and where it goes.
struct PayloadPart {
  std::size_t first_word;
  std::span<const std::uint64_t> words;
};

/// Publishes snapshot n = 1, 2, ... : one writer, any number of readers, nobody waits.
///
/// Thread: the writer's only. Realtime: wait-free, one store a word.
template <class Atomics = HardwareAtomics>
void publish(const DoubleBuffer& buffer, std::uint64_t n,
             std::initializer_list<PayloadPart> parts) noexcept {
  std::uint64_t& sequence = *buffer.sequence[n % 2];
  std::uint64_t* payload = buffer.payload[n % 2];
  Atomics::store(sequence, 2 * n - 1, std::memory_order_release);  // W1 odd: being written
  Atomics::fence(std::memory_order_release);                       // W2
  for (const PayloadPart& part : parts) {                          // W3
    std::uint64_t* target = payload + part.first_word;
    // Atomic stores are not vectorised: without unrolling the loop itself is half of the cost.
#pragma GCC unroll 8
    for (const std::uint64_t word : part.words)
      Atomics::store(*target++, word, std::memory_order_relaxed);
  }
  Atomics::store(sequence, 2 * n, std::memory_order_release);    // W4
  Atomics::store(*buffer.latest, n, std::memory_order_release);  // W5
}

enum class ReadStatus { kAccepted, kEmpty, kContended };

/// Result of a read, and how many attempts it took. A torn copy is never shown.
struct ReadResult {
  ReadStatus status = ReadStatus::kEmpty;
  std::uint64_t snapshot_id = 0;
  int attempts = 0;
};

/// Reads the latest snapshot: at most two attempts, and never a torn or mixed one.
///
/// gather(payload) copies the words it needs, each by a relaxed load, into memory of its own; what
/// it copied may be used only after kAccepted. It may be called twice and must bound every index by
/// itself, for the words it sees may be of two snapshots.
/// Thread: any reader. Realtime: wait-free.
template <class Atomics = HardwareAtomics, class Gather>
ReadResult read_latest(const DoubleBuffer& buffer, Gather&& gather) {
  ReadResult result;
  for (; result.attempts < 2;) {
    const std::uint64_t n = Atomics::load(*buffer.latest, std::memory_order_acquire);  // R1
    if (n == 0) return result;
    ++result.attempts;
    result.status = ReadStatus::kContended;
    const std::uint64_t& sequence = *buffer.sequence[n % 2];
    if (Atomics::load(sequence, std::memory_order_acquire) != 2 * n) continue;  // R2
    gather(static_cast<const std::uint64_t*>(buffer.payload[n % 2]));           // R3
    Atomics::fence(std::memory_order_acquire);                                  // R4
    if (Atomics::load(sequence, std::memory_order_acquire) != 2 * n) continue;  // R5
    result.status = ReadStatus::kAccepted;
    result.snapshot_id = n;
    return result;
  }
  return result;
}

/// One relaxed load of a shared word. Realtime: yes.
template <class Atomics = HardwareAtomics>
[[nodiscard]] std::uint64_t load_word(const std::uint64_t* words, std::size_t index) noexcept {
  return Atomics::load(words[index], std::memory_order_relaxed);
}

/// Element `index` of an array of 32-bit numbers laid over shared words. Realtime: yes.
template <class Atomics = HardwareAtomics>
[[nodiscard]] std::uint32_t load_u32(const std::uint64_t* words, std::size_t index) noexcept {
  const std::uint64_t word = load_word<Atomics>(words, index / 2);
  return static_cast<std::uint32_t>(word >> (32 * (index % 2)));
}

/// Copies a struct of whole words out of shared memory, a relaxed load a word. Realtime: yes.
template <class T, class Atomics = HardwareAtomics>
[[nodiscard]] T load_struct(const std::uint64_t* words) noexcept {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % 8 == 0);
  std::array<std::uint64_t, sizeof(T) / 8> local;
  for (std::size_t i = 0; i < local.size(); ++i) local[i] = load_word<Atomics>(words, i);
  return std::bit_cast<T>(local);
}

/// Returns the latest payload as a struct, or std::nullopt if no read was accepted.
/// Realtime: wait-free.
template <class T>
[[nodiscard]] std::optional<T> read_struct(const DoubleBuffer& buffer) noexcept {
  T payload{};
  const ReadResult result =
      read_latest(buffer, [&](const std::uint64_t* words) { payload = load_struct<T>(words); });
  if (result.status != ReadStatus::kAccepted) return std::nullopt;
  return payload;
}

}  // namespace stillgrid::double_buffer
