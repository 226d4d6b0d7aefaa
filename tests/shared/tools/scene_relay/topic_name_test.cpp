#include "shared/tools/scene_relay/topic_name.hpp"

#include <catch2/catch.hpp>
#include <random>
#include <set>
#include <string>

#include "shared/publication/segment.hpp"
#include "shared/tools/scene_relay/messages.hpp"
#include "shared/tools/scene_relay/network.hpp"

namespace stillgrid::scene_relay::topic_name_test {
namespace {

/// Of the letters that a session's name is made of, and of few, so that names differ by little.
std::string drawn_session(std::mt19937& random) {
  const std::string letters = "aA7_-.25e";
  std::uniform_int_distribution<std::size_t> letter(0, letters.size() - 1), length(0, 5);
  std::string name = "s";
  for (std::size_t left = length(random); left > 0; --left) name += letters[letter(random)];
  if (length(random) > 3) name += "+left";
  return name;
}

TEST_CASE("No two sessions have the same topics", "[relay]") {
  std::mt19937 random(GENERATE(1U, 2U, 3U));
  std::set<std::string> sessions, parts;
  for (int i = 0; i < 2000; ++i) sessions.insert(drawn_session(random));
  for (const std::string& session : sessions) parts.insert(topic_part(session));
  CHECK(parts.size() == sessions.size());
}

TEST_CASE("Every name of a session names a topic that DDS accepts", "[relay]") {
  NetworkOptions loopback;
  loopback.domain = 217;  // nobody else's
  const Participant participant(loopback);
  const std::string session = GENERATE("demo", "demo-2", "demo.2", "demo_2", "2", "demo+left",
                                       "a-b.c_d+hand_2", "1000/demo+right");
  CHECK_NOTHROW(participant.writer(
      stillgrid_Greeting_desc, "stillgrid/greeting/" + topic_part(session), Delivery::kBestEffort));
}

}  // namespace
}  // namespace stillgrid::scene_relay::topic_name_test
