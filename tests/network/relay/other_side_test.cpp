#include "shared/tools/scene_relay/other_side.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace stillgrid::scene_relay::other_side_test {
namespace {

/// A relay without a network: what it reports, and what it would send.
struct Relay {
  Relay(std::uint64_t id, Role role)
      : side(id, role, "organ", [this](const std::string& line) { lines.push_back(line); }) {}
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  [[nodiscard]] std::size_t count(const std::string& part) const {
    return static_cast<std::size_t>(std::count_if(
        lines.begin(), lines.end(),
        [&](const std::string& line) { return line.find(part) != std::string::npos; }));
  }

  std::vector<std::string> lines;
  OtherSide side;
};

/// Both tell each other how it is, each so many ns.
void talk(Relay& a, Relay& b, std::uint64_t& now_ns, int rounds,
          std::uint64_t period_ns = 97'000'000) {
  for (int i = 0; i < rounds; ++i) {
    now_ns += period_ns;
    a.side.hear(b.side.next_status(now_ns), now_ns);
    b.side.hear(a.side.next_status(now_ns + 700'000), now_ns + 1'100'000);
    a.side.look(now_ns + 1'100'000);
    b.side.look(now_ns + 1'100'000);
  }
}

Greeting greeting_of(std::uint64_t id, Role role, std::uint32_t protocol,
                     const std::string& release) {
  Greeting greeting{};
  greeting.relay_id = id;
  greeting.role = static_cast<std::uint32_t>(role);
  greeting.protocol = protocol;
  std::copy_n(release.begin(), std::min(release.size(), sizeof greeting.release), greeting.release);
  return greeting;
}

}  // namespace

TEST_CASE("Two relays of one release join with a line each, and know each other's clock",
          "[other_side]") {
  Relay simulation(0x51, Role::kSimulation), hand(0x4A, Role::kHand);
  std::uint64_t now_ns = 3'000'000'007;
  simulation.side.hear(hand.side.greeting());
  hand.side.hear(simulation.side.greeting());
  talk(hand, simulation, now_ns, 23);
  CHECK(hand.lines == std::vector<std::string>{"joined with the relay beside the simulation"});
  CHECK(simulation.lines == std::vector<std::string>{"joined with the relay beside the hand"});
  CHECK(hand.side.clock().is_known());
  CHECK(simulation.side.clock().is_known());
  CHECK(hand.side.followed() == 0x51);
  CHECK(hand.side.is_followed(0x51));
  CHECK_FALSE(hand.side.is_followed(0));
  CHECK_FALSE(hand.side.is_followed(0x52));
  CHECK(hand.side.partitions() == 0);
}

TEST_CASE("A relay of another protocol is told of once, and both releases are named",
          "[other_side]") {
  Relay hand(0x4A, Role::kHand);
  for (int i = 0; i < 7; ++i)
    for (const std::uint64_t id : {0x91U, 0x92U})
      hand.side.hear(greeting_of(id, Role::kSimulation, kProtocol + 1, "9.7.3"));
  REQUIRE(hand.lines.size() == 2);
  CHECK(hand.lines[0].find("9.7.3") != std::string::npos);
  CHECK(hand.lines[0].find("protocol " + std::to_string(kProtocol + 1)) != std::string::npos);
  CHECK(hand.side.followed() == 0);
  // Its own word, and that of another beside the hand, is none of the other side.
  hand.side.hear(greeting_of(0x4A, Role::kSimulation, 9, "x"));
  hand.side.hear(greeting_of(0x93, Role::kHand, 9, "x"));
  CHECK(hand.lines.size() == 2);
}

TEST_CASE("A release of whatever bytes is printed as text, and strangers do not flood",
          "[other_side]") {
  const auto seed = GENERATE(range(1U, 6U));
  std::mt19937 random(seed);
  Relay hand(0x4A, Role::kHand);
  std::vector<std::string> printed;
  for (std::uint64_t id = 1; id < 700; ++id) {
    std::string release(id % 2 == 0 ? 33 : random() % 33, '\0');  // half of them without an end
    for (char& c : release) c = static_cast<char>(1 + random() % 255);
    hand.side.hear(greeting_of(id, Role::kSimulation, 7, release));
    std::replace_if(
        release.begin(), release.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    printed.push_back("is of Stillgrid " + release + " and speaks protocol 7");
  }
  REQUIRE_FALSE(hand.lines.empty());
  CHECK(hand.lines.size() <= 16);
  for (std::size_t i = 0; i < hand.lines.size(); ++i) {
    const std::string& line = hand.lines[i];
    CHECK(line.find(printed[i]) != std::string::npos);
    CHECK(std::all_of(line.begin(), line.end(), [](char c) { return c >= ' ' && c <= '~'; }));
  }
}

TEST_CASE("A silence is told once, counted and measured when it ends", "[other_side]") {
  const auto seed = GENERATE(range(1U, 6U));
  std::mt19937 random(seed);
  Relay simulation(0x51, Role::kSimulation), hand(0x4A, Role::kHand);
  std::uint64_t now_ns = 3'000'000'007, longest_ns = 0;
  for (std::uint64_t silence = 0; silence < 5; ++silence) {
    talk(hand, simulation, now_ns, 11);
    CHECK(hand.side.is_connected());
    CHECK(hand.side.partitions() == silence);
    const std::uint64_t silence_ns = 600'000'000 + random() % 9'000'000'000;
    const std::uint64_t from_ns = now_ns;
    for (; now_ns + 97'000'000 < from_ns + silence_ns; now_ns += 1'000'003) hand.side.look(now_ns);
    longest_ns = std::max(longest_ns, now_ns + 97'000'000 - from_ns);
    CHECK_FALSE(hand.side.is_connected());
  }
  talk(hand, simulation, now_ns, 3);
  CHECK(hand.count("nothing is heard of") == 5);
  CHECK(hand.count("is heard again") == 5);
  CHECK(hand.side.partitions() == 5);
  CHECK(hand.side.longest_silence_ns() == longest_ns);
  CHECK(hand.side.followed() == 0x51);
}

TEST_CASE("A relay that is heard and hears nothing itself is told of once", "[other_side]") {
  Relay simulation(0x51, Role::kSimulation), hand(0x4A, Role::kHand);
  std::uint64_t now_ns = 3'000'000'007;
  CHECK_FALSE(hand.side.is_hearing());
  talk(hand, simulation, now_ns, 11);
  CHECK(hand.side.is_hearing());
  const std::uint64_t from_ns = now_ns;
  std::uint64_t deaf_ns = 0;
  for (int i = 0; i < 31; ++i) {  // what the hand says is lost
    now_ns += 97'000'000;
    hand.side.hear(simulation.side.next_status(now_ns), now_ns);
    hand.side.look(now_ns);
    if (deaf_ns == 0 && !hand.side.is_hearing()) deaf_ns = now_ns - from_ns;
  }
  CHECK(hand.side.is_connected());
  CHECK_FALSE(hand.side.is_hearing());
  CHECK(deaf_ns >= OtherSide::kPatience_ns - 200'000'000);
  CHECK(deaf_ns <= OtherSide::kPatience_ns + 200'000'000);
  CHECK(hand.count("hears nothing") == 1);
  talk(hand, simulation, now_ns, 3);
  CHECK(hand.side.is_hearing());
}

TEST_CASE("Of two relays the first is kept to until it falls silent, then the other takes over",
          "[other_side]") {
  Relay first(0x51, Role::kSimulation), second(0x52, Role::kSimulation), hand(0x4A, Role::kHand);
  std::uint64_t now_ns = 3'000'000'007;
  for (int i = 0; i < 29; ++i) {
    talk(hand, first, now_ns, 1);
    CHECK_FALSE(hand.side.hear(second.side.next_status(now_ns + 90'000'000), now_ns));
    second.side.hear(hand.side.next_status(now_ns), now_ns);
  }
  CHECK(hand.side.followed() == 0x51);
  CHECK(hand.count("two relays beside the simulation join session 'organ'") == 1);
  CHECK(second.count("keeps to another than this one") == 1);
  // The first is killed. The second is heard when the patience is over, not before.
  const std::uint64_t heard_ns = now_ns;
  while (hand.side.followed() == 0x51) {
    now_ns += 20'000'000;
    hand.side.look(now_ns);
    hand.side.hear(second.side.next_status(now_ns), now_ns);
    REQUIRE(now_ns < heard_ns + 2'000'000'000);
  }
  CHECK(now_ns >= heard_ns + OtherSide::kPatience_ns);
  CHECK(now_ns < heard_ns + OtherSide::kPatience_ns + 20'000'001);
  CHECK(hand.count("another relay beside the simulation takes over session 'organ'") == 1);
  CHECK(hand.side.longest_silence_ns() == now_ns - heard_ns);
  CHECK_FALSE(hand.side.clock().is_known());  // another machine's, perhaps
  talk(hand, second, now_ns, 9);
  CHECK(hand.side.clock().is_known());
}

TEST_CASE("Two strangers that are heard in turns are told of once each", "[other_side]") {
  Relay first(0x51, Role::kSimulation), second(0x52, Role::kSimulation), hand(0x4A, Role::kHand);
  std::uint64_t now_ns = 3'000'000'007;
  for (int i = 0; i < 41; ++i) {
    talk(hand, first, now_ns, 1);
    hand.side.hear(second.side.next_status(now_ns), now_ns);
    hand.side.hear(greeting_of(0x53, Role::kSimulation, kProtocol + 5, "0.1"));
  }
  CHECK(hand.lines.size() == 3);
}

TEST_CASE("A status that is old, its own, nobody's or without a number says nothing",
          "[other_side]") {
  Relay simulation(0x51, Role::kSimulation), hand(0x4A, Role::kHand);
  std::uint64_t now_ns = 3'000'000'007;
  const Status early = simulation.side.next_status(now_ns);
  talk(hand, simulation, now_ns, 11);
  const Status last = hand.side.status();
  const std::int64_t offset_ns = hand.side.clock().offset_ns();
  Status odd = last;
  CHECK_FALSE(hand.side.hear(early, now_ns));
  CHECK_FALSE(hand.side.hear(last, now_ns));
  odd.number += 100;
  odd.relay_id = 0;
  CHECK_FALSE(hand.side.hear(odd, now_ns));
  odd.relay_id = 0x4A;
  CHECK_FALSE(hand.side.hear(odd, now_ns));
  CHECK(std::memcmp(&hand.side.status(), &last, sizeof last) == 0);
  CHECK(hand.side.clock().offset_ns() == offset_ns);
  // One without a number takes no silent relay's place either.
  now_ns += 2'000'000'000;
  hand.side.look(now_ns);
  odd.relay_id = 0x99;
  odd.number = 0;
  CHECK_FALSE(hand.side.hear(odd, now_ns));
  CHECK(hand.side.followed() == 0x51);
  CHECK(hand.count("takes over") == 0);
}

}  // namespace stillgrid::scene_relay::other_side_test
