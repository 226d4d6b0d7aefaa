#include "shared/tools/scene_viewer/mouse_hands.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "shared/tools/scene_viewer/checked_json.hpp"

namespace stillgrid::scene_viewer {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kLongestHolder = 32;
constexpr std::uint64_t kButtons = 0xFF;

template <std::size_t N>
bool read_numbers(const Json& json, std::array<double, N>& numbers) {
  if (!json.is_array() || json.size() != N) return false;
  for (std::size_t i = 0; i < N; ++i) {
    if (!json[i].is_number()) return false;
    numbers[i] = json[i].get<double>();
  }
  return true;
}

bool is_holder(const std::string& text) {
  return !text.empty() && text.size() <= kLongestHolder &&
         std::all_of(text.begin(), text.end(),
                     [](unsigned char c) { return std::isalnum(c) != 0 && c < 0x80; });
}

}  // namespace

std::optional<MouseMessage> mouse_message(std::string_view body) {
  const auto json = parse_shallow<Json>(body);
  MouseMessage message{};
  const Json& holder = at(json, "holder");
  if (!holder.is_string()) return std::nullopt;
  message.holder = holder.get<std::string>();
  if (!is_holder(message.holder)) return std::nullopt;
  const Json& release = at(json, "release");
  message.is_release = release.is_boolean() && release.get<bool>();
  if (message.is_release) return message;

  const Json& buttons = at(json, "buttons");
  if (!read_numbers(at(json, "position_m"), message.pose.position_m) ||
      !read_numbers(at(json, "orientation_xyzw"), message.pose.orientation_xyzw) ||
      !publication::is_sound(message.pose) || !buttons.is_number_unsigned())
    return std::nullopt;
  message.pose.buttons = buttons.get<std::uint64_t>();
  if (message.pose.buttons > kButtons) return std::nullopt;
  return message;
}

std::string MouseHands::move(const std::string& session, const MouseMessage& message,
                             std::uint64_t now_ns) {
  drop_silent(now_ns);
  auto hold = holds_.find(session);
  const bool is_held = hold != holds_.end();
  if (is_held && hold->second.holder != message.holder)
    return message.is_release ? "" : "another page holds the hand: let it go there, or close it";
  if (message.is_release) {
    if (is_held) holds_.erase(hold);
    return "";
  }
  if (!is_held) {
    auto lock = publication::SessionLock::try_take(session, proto::SegmentKind::kMouse);
    if (!lock) return "a page of another viewer holds the hand: let it go there, or close it";
    hold = holds_
               .emplace(std::piecewise_construct, std::forward_as_tuple(session),
                        std::forward_as_tuple(message.holder, now_ns, std::move(*lock)))
               .first;
  }
  hold->second.heard_ns = now_ns;
  proto::MousePose pose = message.pose;
  pose.time_ns = now_ns;
  hold->second.writer.publish(pose);
  return "";
}

void MouseHands::drop_silent(std::uint64_t now_ns) {
  std::erase_if(holds_, [&](const auto& hold) { return now_ns - hold.second.heard_ns > kHeld_ns; });
}

}  // namespace stillgrid::scene_viewer
