#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace stillgrid::publication {

/// What joins a session's name and a hand's.
inline constexpr char kHandMark = '+';

/// What is wrong with a hand's name, or nothing: a check for command lines and scenes.
[[nodiscard]] std::string hand_complaint(const std::string& name);

/// SESSION+HAND, under which a hand's segments stand; SESSION for a hand without a name.
[[nodiscard]] std::string hand_session(std::string_view session, std::string_view hand);

/// SESSION of SESSION+HAND, and HAND; empty without a name.
[[nodiscard]] std::string_view session_of(std::string_view hand_session) noexcept;
[[nodiscard]] std::string_view hand_of(std::string_view hand_session) noexcept;

/// The sessions whose sim_server lives and has published, and which this process may read: SESSION,
/// or SESSION+HAND for each hand that has a name. Throws SegmentError as list_segments().
[[nodiscard]] std::vector<std::string> running_sessions();

/// The hands of a session, by name, whose sim_server lives and has published for one of them at
/// least; "" is the hand without a name. Throws SegmentError as list_segments().
[[nodiscard]] std::vector<std::string> hands_of_session(std::string_view session);

/// Throws SegmentError, one line that names the hands there are, where a sim_server publishes the
/// session but not for this hand.
void require_hand(std::string_view hand_session);

}  // namespace stillgrid::publication
