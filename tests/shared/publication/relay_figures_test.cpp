#include "shared/publication/relay_figures.hpp"

#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstring>
#include <random>

#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::publication::relay_figures_test {
namespace {

using Words = std::array<std::uint64_t, sizeof(proto::RelayFigures) / 8>;
constexpr std::size_t kIdWord = 0, kConnectedWord = 1, kOffsetWord = 2, kFirstReservedWord = 14;

bool is_time(std::size_t word) {
  return word == offsetof(proto::RelayFigures, clock_bound_ns) / 8 ||
         word == offsetof(proto::RelayFigures, round_trip_ns) / 8 ||
         word == offsetof(proto::RelayFigures, longest_silence_ns) / 8;
}

/// The largest that a relay writes into that word.
std::uint64_t largest(std::size_t word) {
  if (word == kIdWord || word >= kFirstReservedWord) return UINT64_MAX;
  if (word == kConnectedWord) return 1;
  return is_time(word) || word == kOffsetWord ? kLongestRelayTime_ns : kLargestRelayCount;
}

Words random_words(std::mt19937_64& random) {
  Words words;
  for (std::size_t i = 0; i < words.size(); ++i)
    words[i] =
        std::uniform_int_distribution<std::uint64_t>(i == kIdWord ? 1 : 0, largest(i))(random);
  if (random() % 2 == 0) words[kOffsetWord] = -words[kOffsetWord];
  return words;
}

/// What a reader that is attached sees of figures stored so.
std::optional<proto::RelayFigures> through_a_segment(const Words& words) {
  const TestSession session;
  SegmentWriter writer(session.name(), small_spec());
  writer.announce();
  const auto reader = open_small(session);
  REQUIRE(reader);
  store_relay_figures(writer.header(), std::bit_cast<proto::RelayFigures>(words));
  return load_relay_figures(reader->live());
}

TEST_CASE("A reader that is attached sees every figure that its relay stores", "[relay]") {
  std::mt19937_64 random(GENERATE(1U, 2U, 3U));
  for (int run = 0; run < 20; ++run) {
    const Words words = random_words(random);
    const auto seen = through_a_segment(words);
    REQUIRE(seen);
    CHECK(std::bit_cast<Words>(*seen) == words);
  }
}

TEST_CASE("A segment that no relay writes tells of none, whatever its other words", "[relay]") {
  CHECK_FALSE(through_a_segment({}));
  std::mt19937_64 random(4);
  Words words = random_words(random);
  words[kIdWord] = 0;
  CHECK_FALSE(through_a_segment(words));
}

TEST_CASE("Figures that no relay writes are not shown, each alone", "[relay]") {
  std::mt19937_64 random(GENERATE(5U, 6U));
  const Words sound = random_words(random);
  for (std::size_t i = kConnectedWord; i < kFirstReservedWord; ++i) {
    CAPTURE(i);
    Words at_the_end = sound, beyond = sound, far = sound;
    at_the_end[i] = largest(i);
    beyond[i] = largest(i) + 1;
    far[i] = std::uniform_int_distribution<std::uint64_t>(largest(i) + 1, UINT64_MAX / 2)(random);
    CHECK(through_a_segment(at_the_end));
    CHECK_FALSE(through_a_segment(beyond));
    CHECK_FALSE(through_a_segment(far));
  }
  Words behind = sound;
  behind[kOffsetWord] = -(kLongestRelayTime_ns + 1);
  CHECK_FALSE(through_a_segment(behind));
  behind[kOffsetWord] = -kLongestRelayTime_ns;
  CHECK(through_a_segment(behind));
}

}  // namespace
}  // namespace stillgrid::publication::relay_figures_test
