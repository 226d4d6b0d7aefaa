#include "tests/model/relaxed_memory.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <cstdint>
#include <set>
#include <utility>

namespace stillgrid::model::relaxed_memory_test {
namespace {

using Values = std::set<std::pair<std::uint64_t, std::uint64_t>>;
constexpr auto kRelaxed = std::memory_order_relaxed;
constexpr auto kAcquire = std::memory_order_acquire;
constexpr auto kRelease = std::memory_order_release;

std::uint64_t any(const RelaxedMemory& memory, Reader& reader, Choices& choices,
                  std::size_t location, std::memory_order order) {
  const std::size_t newest = memory.newest(location);
  const std::size_t message = newest - choices.choose(newest - reader.current[location] + 1);
  return reader.load(memory, location, message, order);
}

/// All that a reader of location 1, then of location 0, may see.
Values seen(const RelaxedMemory& memory, std::memory_order first, bool has_fence = false) {
  Values values;
  Choices choices;
  do {
    Reader reader;
    const std::uint64_t flag = any(memory, reader, choices, 1, first);
    if (has_fence) reader.acquire_fence();
    values.emplace(flag, any(memory, reader, choices, 0, kRelaxed));
  } while (choices.next());
  return values;
}

const Values kAnything{{0, 0}, {0, 1}, {1, 0}, {1, 1}};
const Values kMessagePassed{{0, 0}, {0, 1}, {1, 1}};

/// Word 0 becomes 1, then word 1: relaxed, released, or relaxed behind a fence.
RelaxedMemory message_passing(std::memory_order flag, bool has_fence = false) {
  RelaxedMemory memory(2);
  memory.start_writer();
  memory.store(0, 1, kRelaxed);
  if (has_fence) memory.release_fence();
  memory.store(1, 1, flag);
  return memory;
}

TEST_CASE("Relaxed loads may see stores to two words in any order", "[model]") {
  CHECK(seen(message_passing(kRelaxed), kRelaxed) == kAnything);
  CHECK(seen(message_passing(kRelaxed), kAcquire) == kAnything);
  CHECK(seen(message_passing(kRelease), kRelaxed) == kAnything);
}

TEST_CASE("An acquire load of a release store sees what was stored before it", "[model]") {
  CHECK(seen(message_passing(kRelease), kAcquire) == kMessagePassed);
}

TEST_CASE("Fences pass on what relaxed stores and loads beyond them do not", "[model]") {
  CHECK(seen(message_passing(kRelaxed, true), kAcquire) == kMessagePassed);
  CHECK(seen(message_passing(kRelease), kRelaxed, true) == kMessagePassed);
  CHECK(seen(message_passing(kRelaxed, true), kRelaxed, true) == kMessagePassed);
  CHECK(seen(message_passing(kRelaxed), kRelaxed, true) == kAnything);
}

TEST_CASE("A word never goes back for one reader, whatever the order", "[model]") {
  RelaxedMemory memory(1);
  memory.start_writer();
  memory.store(0, 1, kRelaxed);
  memory.store(0, 2, kRelaxed);
  Values pairs;
  Choices choices;
  do {
    Reader reader;
    const std::uint64_t first = any(memory, reader, choices, 0, kRelaxed);
    pairs.emplace(first, any(memory, reader, choices, 0, kRelaxed));
  } while (choices.next());
  CHECK(pairs == Values{{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}});
}

TEST_CASE("A relaxed store after a release store to the same word passes nothing on", "[model]") {
  RelaxedMemory memory(2);
  memory.start_writer();
  memory.store(0, 1, kRelaxed);
  memory.store(1, 1, kRelease);
  memory.store(1, 2, kRelaxed);
  CHECK(seen(memory, kAcquire) == Values{{0, 0}, {0, 1}, {1, 1}, {2, 0}, {2, 1}});
}

TEST_CASE("A successor's release store passes on what the dead writer stored, its relaxed one not",
          "[model]") {
  const std::memory_order order = GENERATE(kRelaxed, kRelease);
  RelaxedMemory memory(2);
  memory.start_writer();
  memory.store(0, 1, kRelaxed);
  memory.release_fence();
  memory.start_writer();
  memory.store(1, 1, order);
  CHECK(seen(memory, kAcquire) == (order == kRelease ? kMessagePassed : kAnything));
}

}  // namespace
}  // namespace stillgrid::model::relaxed_memory_test
