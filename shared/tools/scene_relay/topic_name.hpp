#pragma once

#include <string>
#include <string_view>

namespace stillgrid::scene_relay {

/// A session's name as a part of a topic's: DDS has letters, digits and _ there, a session also has
/// '-', '.', and '+' before its hand. What is no letter or digit is _ and its number in hexadecimal
/// digits, so that no two sessions share a topic.
[[nodiscard]] std::string topic_part(std::string_view session);

}  // namespace stillgrid::scene_relay
