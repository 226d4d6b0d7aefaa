#include "shared/tools/scene_viewer/mouse_hands.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::scene_viewer::mouse_hands_test {
namespace {

constexpr std::uint64_t kNow_ns = 7'000'000'000;
const std::string kGood =
    R"({"holder":"a1","position_m":[0.1,-2e-1,3],"orientation_xyzw":[0,0,0,1],"buttons":1})";

std::string with(const std::string& from, const std::string& to) {
  std::string text = kGood;
  return text.replace(text.find(from), from.size(), to);
}

std::optional<publication::MouseView> view_of(const publication::TestSession& session) {
  auto reader = publication::SegmentReader::open(session.name(), proto::SegmentKind::kMouse,
                                                 proto::kMouseLayoutHash);
  if (!reader) return std::nullopt;
  return publication::MouseView(std::move(*reader));
}

TEST_CASE("A message is taken as it is meant, and none that cannot be", "[mouse_hands]") {
  const auto message = mouse_message(kGood);
  REQUIRE(message);
  CHECK(message->holder == "a1");
  CHECK(message->pose.position_m == std::array{0.1, -0.2, 3.0});
  CHECK(message->pose.buttons == 1);
  CHECK(mouse_message(R"({"holder":"a1","release":true})")->is_release);
  for (const std::string& text : {std::string(),
                                  std::string("{}"),
                                  std::string("null"),
                                  std::string("[1]"),
                                  std::string("\"a\""),
                                  std::string(1000, '['),
                                  with("\"a1\"", "\"\""),
                                  with("\"a1\"", "1"),
                                  with("\"a1\"", "\"../a\""),
                                  with("\"a1\"", "\"" + std::string(33, 'a') + "\""),
                                  with("0.1", "NaN"),
                                  with("0.1", "null"),
                                  with("0.1", "1e999"),
                                  with("0.1", "11"),
                                  with("0.1", "\"0.1\""),
                                  with("0.1,", ""),
                                  with("0.1", "0,0.1"),
                                  with("0,0,0,1", "0,0,0,0"),
                                  with("0,0,0,1", "0,0,0,2"),
                                  with("0,0,0,1", "0,0,1"),
                                  with(":1}", ":-1}"),
                                  with(":1}", ":256}"),
                                  with(":1}", ":1.5}"),
                                  with(":1}", ":true}"),
                                  with("buttons", "button"),
                                  std::string(R"({"holder":"a1","release":1})")})
    CHECK_FALSE(mouse_message(text));
}

TEST_CASE("Whatever a page sends, it is a message or none", "[mouse_hands]") {
  std::mt19937 random(1);
  for (int i = 0; i < 20'000; ++i) {
    std::string text = kGood;
    for (std::uint32_t spoilt = random() % 4; spoilt > 0; --spoilt)
      text[random() % text.size()] = static_cast<char>(random());
    text.resize(text.size() - random() % 3);
    const auto message = mouse_message(text);
    if (message && !message->is_release) REQUIRE(publication::is_sound(message->pose));
  }
}

TEST_CASE("One page holds a hand, until it lets go or is silent", "[mouse_hands]") {
  const publication::TestSession session;
  MouseHands hands, of_another_viewer;
  const MouseMessage first = *mouse_message(kGood);
  MouseMessage second = first, let_go = first;
  second.holder = "b2";
  let_go.is_release = true;
  CHECK(hands.move(session.name(), first, kNow_ns).empty());
  const auto view = view_of(session);
  REQUIRE(view);
  REQUIRE(view->read());
  CHECK(view->read()->time_ns == kNow_ns);
  CHECK(view->read()->position_m == first.pose.position_m);

  CHECK(hands.move(session.name(), second, kNow_ns + 1).starts_with("another page holds the hand"));
  CHECK(of_another_viewer.move(session.name(), second, kNow_ns + 1)
            .starts_with("a page of another viewer holds the hand"));
  CHECK(view->read()->time_ns == kNow_ns);
  MouseMessage others_release = let_go;
  others_release.holder = "b2";
  CHECK(hands.move(session.name(), others_release, kNow_ns + 2).empty());
  CHECK(view->reader().writer_alive());

  CHECK(hands.move(session.name(), let_go, kNow_ns + 3).empty());
  CHECK_FALSE(view->reader().writer_alive());
  CHECK(of_another_viewer.move(session.name(), second, kNow_ns + 4).empty());
  of_another_viewer.drop_silent(kNow_ns + 4 + MouseHands::kHeld_ns);
  CHECK_FALSE(hands.move(session.name(), first, kNow_ns + 5).empty());
  of_another_viewer.drop_silent(kNow_ns + 5 + MouseHands::kHeld_ns);
  CHECK(hands.move(session.name(), first, kNow_ns + 6).empty());
  CHECK(hands.move(session.name(), second, kNow_ns + 7 + MouseHands::kHeld_ns).empty());
}

}  // namespace
}  // namespace stillgrid::scene_viewer::mouse_hands_test
