#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace stillgrid::model {

inline constexpr std::size_t kMaxLocations = 16;

/// For each location the index of a message; nothing older may be read there by who holds the view.
using View = std::array<std::uint8_t, kMaxLocations>;

/// A store, as it stays in its location's history.
struct Message {
  std::uint64_t value = 0;
  std::uint8_t writer = 0;  // 0: there from the start
  View view{};              // what a reader that acquires this message knows
};

/// Memory of the C++20 model as its writers leave it: no location ever forgets a store.
///
/// This is the view machine of Kang et al., "A Promising Semantics for Relaxed-Memory Concurrency",
/// POPL 2017, without promises and with the release sequences of C++20. Its stores all come from
/// one writer at a time, so the order of stores to a location is that in which they are made here.
/// One writer follows another only when a lock has shown that the first is dead: it knows every
/// store made so far, and its own release stores pass all of them on.
class RelaxedMemory {
 public:
  explicit RelaxedMemory(std::size_t locations);

  /// The writer of all stores from now on; it has made no fence yet.
  void start_writer() noexcept;

  /// A release store carries all that its writer knows; a relaxed one what it knew at its last
  /// release fence.
  void store(std::size_t location, std::uint64_t value, std::memory_order order);
  void release_fence() noexcept { released_ = newest_; }

  [[nodiscard]] const Message& message(std::size_t location, std::size_t index) const {
    return messages_[location][index];
  }
  [[nodiscard]] std::size_t newest(std::size_t location) const { return newest_[location]; }
  [[nodiscard]] std::uint8_t writer() const noexcept { return writer_; }

 private:
  std::array<std::vector<Message>, kMaxLocations> messages_;
  View newest_{};
  View released_{};  // at the writer's last release fence
  std::uint8_t writer_ = 0;
};

/// What a reader knows. Its order of members makes states comparable.
struct Reader {
  View current{};  // no load may be answered by an older message
  View pending{};  // what an acquire fence would make of it: all that the messages read know

  /// Reads that message. An acquire load learns its view at once, a relaxed one at the next fence.
  /// Pre: index is between current[location] and the newest message.
  std::uint64_t load(const RelaxedMemory& memory, std::size_t location, std::size_t index,
                     std::memory_order order) noexcept;
  void acquire_fence() noexcept { current = pending; }

  auto operator<=>(const Reader&) const = default;
};

/// Enumerates, depth first, all sequences of choices that a program can make: it is run anew for
/// each, repeats all choices but the last one that had an alternative, and goes on with zeros.
class Choices {
 public:
  /// A number below `count`. Zero throughout the first run.
  std::size_t choose(std::size_t count);

  /// Before the next run; false when there is none left.
  bool next();

 private:
  struct Choice {
    std::size_t chosen;
    std::size_t count;
  };
  std::vector<Choice> made_;
  std::size_t repeated_ = 0;
};

}  // namespace stillgrid::model
