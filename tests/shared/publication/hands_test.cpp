#include "shared/publication/hands.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "shared/publication/segment.hpp"
#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::publication::hands_test {

TEST_CASE("A hand's session is its session's name, '+' and its own", "[hands]") {
  CHECK(hand_session("demo", "left") == "demo+left");
  CHECK(hand_session("demo", "") == "demo");
  CHECK(session_of("1000/demo+left") == "1000/demo");
  CHECK(hand_of("1000/demo+left") == "left");
  CHECK(hand_of("demo").empty());
  CHECK(segment_name("demo+left", proto::SegmentKind::kTool) == "demo+left-tool");
  for (const char* name : {"", "a b", "a+b", "a.b", "seventeen_letters"})
    CHECK_FALSE(hand_complaint(name).empty());
  for (const char* name : {"demo+", "+left", "demo+a+b", "demo+a.b"})
    CHECK_THROWS_AS(segment_name(name, proto::SegmentKind::kScene), SegmentError);
  std::string with_hand = "demo+left";
  CHECK_FALSE(settle_session(with_hand).empty());
  CHECK(settle_hand_session(with_hand).empty());
}

TEST_CASE("Who asks for a hand that a session has not is told which it has", "[hands]") {
  const TestSession session;
  const std::string left = hand_session(session.name(), "left"),
                    right = hand_session(session.name(), "right");
  require_hand(left);  // nobody publishes: it may come
  {
    SessionLock later(right, proto::SegmentKind::kScene);
    require_hand(left);  // it still loads
    const SegmentWriter first(left, small_spec());
    CHECK(hands_of_session(session.name()) == std::vector<std::string>{"left", "right"});
    require_hand(left);
    require_hand(right);
    CHECK(refusal_of([&] { require_hand(session.name()); }).find("'left', 'right'") !=
          std::string::npos);
    CHECK(refusal_of([&] { require_hand(left + "er"); }).find("'lefter'") != std::string::npos);
  }
  CHECK(hands_of_session(session.name()).empty());
  const SegmentWriter alone(session.name(), small_spec());
  CHECK(refusal_of([&] { require_hand(left); }).find("expected no --hand") != std::string::npos);
}

}  // namespace stillgrid::publication::hands_test
