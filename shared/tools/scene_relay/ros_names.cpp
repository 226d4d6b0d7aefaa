#include "shared/tools/scene_relay/ros_names.hpp"

#include <algorithm>
#include <stdexcept>

#include "shared/publication/hands.hpp"

namespace stillgrid::scene_relay {
namespace {

// Not std::isalnum: what a letter is would depend on the locale.
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
bool is_allowed(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || is_digit(c) || c == '_';
}

/// Throws unless ROS takes the text between two '/' of a topic's name.
void require_token(const char* option, std::string_view text) {
  if (!text.empty() && !is_digit(text.front()) && std::all_of(text.begin(), text.end(), is_allowed))
    return;
  throw std::invalid_argument(std::string(option) + ": value '" + std::string(text) +
                              "' is no part of a ROS topic's name: expected letters, digits and "
                              "'_', no digit first");
}

}  // namespace

RosNames ros_names(std::string_view hand_session) {
  const std::size_t user_end = hand_session.find('/');
  if (user_end != std::string_view::npos) hand_session.remove_prefix(user_end + 1);
  const std::string_view session = publication::session_of(hand_session);
  const std::string_view hand = publication::hand_of(hand_session);
  require_token("--session", session);
  RosNames names;
  names.frame = "stillgrid/" + std::string(session);
  std::string space = "/" + names.frame;
  if (!hand.empty()) {
    require_token("--hand", hand);
    (space += '/') += hand;
  }
  names.pose_topic = space + "/tool_pose";
  names.wrench_topic = space + "/tool_wrench";
  return names;
}

std::string dds_name(std::string_view ros_topic) {
  return "rt" + std::string(ros_topic);
}

}  // namespace stillgrid::scene_relay
