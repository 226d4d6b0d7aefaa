#include "shared/publication/hands.hpp"

#include <algorithm>

#include "shared/publication/segment_files.hpp"
#include "shared/publication/segment_place.hpp"

namespace stillgrid::publication {
namespace {

constexpr std::size_t kLongestHand = 16;

bool is_published(std::string_view session) {
  const FileDescriptor object = open_as_found(segment_path(session, proto::SegmentKind::kScene));
  return object.get() >= 0 && is_object_locked(object.get());
}

}  // namespace

std::string hand_complaint(const std::string& name) {
  const auto is_allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  };
  const bool is_good = !name.empty() && name.size() <= kLongestHand &&
                       std::all_of(name.begin(), name.end(), is_allowed);
  return is_good ? "" : "value '" + name + "': expected 1 to 16 letters, digits, '_' or '-'";
}

std::string hand_session(std::string_view session, std::string_view hand) {
  std::string name(session);
  if (!hand.empty()) (name += kHandMark) += hand;
  return name;
}

std::string_view session_of(std::string_view hand_session) noexcept {
  return hand_session.substr(0, hand_session.find(kHandMark));
}

std::string_view hand_of(std::string_view hand_session) noexcept {
  const std::size_t mark = hand_session.find(kHandMark);
  return mark == std::string_view::npos ? "" : hand_session.substr(mark + 1);
}

std::vector<std::string> running_sessions() {
  std::vector<std::string> sessions;
  for (const SegmentFile& file : list_segments())
    if (file.kind == proto::SegmentKind::kScene && is_published(file.session))
      sessions.push_back(file.session);
  return sessions;
}

std::vector<std::string> hands_of_session(std::string_view session) {
  std::vector<std::string> hands;
  bool is_any_published = false;
  for (const SegmentFile& file : list_segments()) {
    if (file.kind != proto::SegmentKind::kScene || session_of(file.session) != session) continue;
    const bool is_seen = is_published(file.session);
    const std::string hand(hand_of(file.session));
    // The lock of the session itself is held beside those of its hands.
    const bool is_held = !hand.empty() && is_writer_loading(file.session, file.kind);
    is_any_published = is_any_published || is_seen;
    if (is_seen || is_held) hands.push_back(hand);
  }
  if (!is_any_published) hands.clear();
  return hands;
}

void require_hand(std::string_view hand_session) {
  const std::vector<std::string> hands = hands_of_session(session_of(hand_session));
  const std::string hand(hand_of(hand_session));
  if (hands.empty() || std::find(hands.begin(), hands.end(), hand) != hands.end()) return;
  const std::string session = "session '" + std::string(session_of(hand_session)) + "' has ";
  if (hands.front().empty())
    throw SegmentError(session + "one hand without a name: expected no --hand");
  std::string names;
  for (const std::string& name : hands) names += (names.empty() ? "'" : ", '") + name + "'";
  throw SegmentError(
      session + "the hands " + names + ": expected " +
      (hand.empty() ? "--hand with one of them" : "one of them, not '" + hand + "'"));
}

}  // namespace stillgrid::publication
