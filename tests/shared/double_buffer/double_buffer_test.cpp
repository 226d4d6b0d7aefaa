#include "shared/double_buffer/double_buffer.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdint>
#include <thread>

#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::double_buffer::double_buffer_test {
namespace {

/// Two slots in private memory.
struct Memory {
  static constexpr std::size_t kWords = publication::kSmallPayloadWords;
  std::uint64_t latest = 0;
  std::array<std::uint64_t, 2> sequence{};
  std::array<std::array<std::uint64_t, kWords>, 2> payload{};

  DoubleBuffer buffer() {
    return {&latest, {&sequence[0], &sequence[1]}, {payload[0].data(), payload[1].data()}};
  }
};
using Words = std::array<std::uint64_t, Memory::kWords>;

Words gather_all(const std::uint64_t* payload) {
  return load_struct<Words>(payload);
}

bool is_whole(const Words& words, std::uint64_t snapshot_id) {
  return std::all_of(words.begin(), words.end(),
                     [&](std::uint64_t word) { return word == publication::word_of(snapshot_id); });
}

TEST_CASE("Before the first publication there is nothing to read", "[double_buffer]") {
  Memory memory;
  bool was_gathered = false;

  const ReadResult result =
      read_latest(memory.buffer(), [&](const std::uint64_t*) { was_gathered = true; });

  CHECK(result.status == ReadStatus::kEmpty);
  CHECK(result.attempts == 0);
  CHECK_FALSE(was_gathered);
}

TEST_CASE("A reader always gets the snapshot last published", "[double_buffer]") {
  Memory memory;
  for (std::uint64_t n = 1; n <= 5; ++n) {
    publication::publish_small(memory.buffer(), n);
    Words words{};
    const ReadResult result = read_latest(
        memory.buffer(), [&](const std::uint64_t* payload) { words = gather_all(payload); });

    REQUIRE(result.status == ReadStatus::kAccepted);
    CHECK(result.snapshot_id == n);
    CHECK(result.attempts == 1);
    CHECK(is_whole(words, n));
  }
}

TEST_CASE("Parts of a snapshot go where they belong and leave the rest alone", "[double_buffer]") {
  Memory memory;
  const std::array<std::uint64_t, 2> head{1, 2};
  const std::array<std::uint64_t, 1> tail{3};

  publish(memory.buffer(), 1, {{0, head}, {10, tail}, {20, {}}});

  CHECK(memory.payload[1][0] == 1);
  CHECK(memory.payload[1][1] == 2);
  CHECK(memory.payload[1][10] == 3);
  CHECK(std::count(memory.payload[1].begin(), memory.payload[1].end(), 0U) == Memory::kWords - 3);
  CHECK(memory.payload[0] == Words{});
}

TEST_CASE("A slot left half written is never shown", "[double_buffer]") {
  Memory memory;
  publication::publish_small(memory.buffer(), 1);
  publication::publish_small(memory.buffer(), 2);
  memory.sequence[0] = 2 * 4 - 1;  // snapshot 4 begun, 3 never announced
  int gathers = 0;

  const ReadResult result = read_latest(memory.buffer(), [&](const std::uint64_t*) { ++gathers; });

  CHECK(result.status == ReadStatus::kContended);
  CHECK(result.attempts == 2);
  CHECK(gathers == 0);
}

/// A writer that dies before its store number `left`.
struct DyingWriter : HardwareAtomics {
  static inline std::size_t left = 0;
  static void store(std::uint64_t& word, std::uint64_t value, std::memory_order order) {
    if (left == 0) return;
    --left;
    HardwareAtomics::store(word, value, order);
  }
};

TEST_CASE("A writer that dies at any store leaves the snapshot before it whole",
          "[double_buffer]") {
  constexpr std::size_t kStores = 1 + Memory::kWords + 2;  // W1, W3, W4, W5
  Words third{};
  third.fill(publication::word_of(3));
  for (std::size_t stores = 0; stores <= kStores; ++stores) {
    Memory memory;
    publication::publish_small(memory.buffer(), 1);
    publication::publish_small(memory.buffer(), 2);
    DyingWriter::left = stores;
    publish<DyingWriter>(memory.buffer(), 3, {{0, third}});
    REQUIRE(DyingWriter::left == 0);

    Words words{};
    const ReadResult result = read_latest(
        memory.buffer(), [&](const std::uint64_t* payload) { words = gather_all(payload); });

    REQUIRE(result.status == ReadStatus::kAccepted);
    REQUIRE(result.snapshot_id == (stores == kStores ? 3 : 2));
    REQUIRE(is_whole(words, result.snapshot_id));
  }
}

/// The reader without its last check: R5, the third load of an attempt, repeats what R2 saw.
struct WithoutLastCheck : HardwareAtomics {
  static inline std::uint64_t loads = 0;
  static inline std::uint64_t seen = 0;
  static std::uint64_t load(const std::uint64_t& word, std::memory_order order) {
    if (++loads % 3 != 0) seen = HardwareAtomics::load(word, order);
    return seen;
  }
};

/// Reads while two publications fall in the middle of the first gather: into the slot being read.
template <class Atomics>
std::pair<ReadResult, Words> read_overtaken(int overtaken_gathers) {
  Memory memory;
  std::uint64_t snapshot_id = 1;
  publication::publish_small(memory.buffer(), snapshot_id);
  Words words{};
  const ReadResult result =
      read_latest<Atomics>(memory.buffer(), [&](const std::uint64_t* payload) {
        for (std::size_t i = 0; i < words.size(); ++i) {
          if (i == words.size() / 2 && overtaken_gathers-- > 0)
            for (int k = 0; k < 2; ++k) publication::publish_small(memory.buffer(), ++snapshot_id);
          words[i] = load_word(payload, i);
        }
      });
  return {result, words};
}

TEST_CASE("An overtaken read is rejected and the second attempt gets the newer snapshot",
          "[double_buffer]") {
  const auto [result, words] = read_overtaken<HardwareAtomics>(1);

  REQUIRE(result.status == ReadStatus::kAccepted);
  CHECK(result.attempts == 2);
  CHECK(result.snapshot_id == 3);
  CHECK(is_whole(words, 3));
}

TEST_CASE("A read overtaken twice gives up rather than show a mixed snapshot", "[double_buffer]") {
  const auto [result, words] = read_overtaken<HardwareAtomics>(2);

  CHECK(result.status == ReadStatus::kContended);
  CHECK(result.attempts == 2);
}

TEST_CASE("Without its last check the same reader shows a mixed snapshot", "[double_buffer]") {
  const auto [result, words] = read_overtaken<WithoutLastCheck>(1);

  REQUIRE(result.status == ReadStatus::kAccepted);
  CHECK(words.front() == publication::word_of(1));
  CHECK(words.back() == publication::word_of(3));
}

TEST_CASE("Beside a writer that never rests no snapshot is torn or older than the last",
          "[double_buffer]") {
  Memory memory;
  std::atomic<bool> stop = false;
  std::thread writer([&, buffer = memory.buffer()] {
    for (std::uint64_t n = 1; !stop.load(std::memory_order_relaxed); ++n)
      publication::publish_small(buffer, n);
  });

  std::uint64_t last = 0, torn = 0, backwards = 0;
  Words words{};
  const auto read_and_check = [&] {
    const ReadResult result = read_latest(
        memory.buffer(), [&](const std::uint64_t* payload) { words = gather_all(payload); });
    if (result.status != ReadStatus::kAccepted) return false;
    if (!is_whole(words, result.snapshot_id)) ++torn;
    if (result.snapshot_id < last) ++backwards;
    last = result.snapshot_id;
    return true;
  };
  while (HardwareAtomics::load(memory.latest, std::memory_order_relaxed) < 500000) read_and_check();
  stop = true;
  writer.join();

  CHECK(read_and_check());  // nobody disturbs it now
  CHECK(torn == 0);
  CHECK(backwards == 0);
}

TEST_CASE("Numbers of 32 bits are read in the order in which memory holds them",
          "[double_buffer]") {
  const std::array<std::uint32_t, 4> numbers{1, 2, 3, 0xFFFFFFFF};
  const auto words = std::bit_cast<std::array<std::uint64_t, 2>>(numbers);
  for (std::size_t i = 0; i < numbers.size(); ++i) CHECK(load_u32(words.data(), i) == numbers[i]);
}

/// Counts the loads of words.
struct CountingLoads : HardwareAtomics {
  static inline int loads = 0;
  static std::uint64_t load(const std::uint64_t& word, std::memory_order order) {
    ++loads;
    return HardwareAtomics::load(word, order);
  }
};

TEST_CASE("Words, numbers and structs are loaded through the policy, a load a word",
          "[double_buffer]") {
  const std::array<std::uint64_t, 3> words{1, 2, 3};
  CountingLoads::loads = 0;
  CHECK(load_word<CountingLoads>(words.data(), 2) == 3);
  CHECK(CountingLoads::loads == 1);
  CHECK(load_u32<CountingLoads>(words.data(), 2) == 2);
  CHECK(CountingLoads::loads == 2);
  CHECK(load_struct<std::array<std::uint64_t, 3>, CountingLoads>(words.data()) == words);
  CHECK(CountingLoads::loads == 5);
}

}  // namespace
}  // namespace stillgrid::double_buffer::double_buffer_test
