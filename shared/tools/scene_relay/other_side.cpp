#include "shared/tools/scene_relay/other_side.hpp"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <utility>

#include "shared/reading/observed_segment.hpp"

namespace stillgrid::scene_relay {
namespace {

constexpr std::uint64_t kExchange_ns = 80'000'000;

const char* place_of(Role role) {
  return role == Role::kSimulation ? "beside the simulation" : "beside the hand";
}
Role other(Role role) {
  return role == Role::kSimulation ? Role::kHand : Role::kSimulation;
}

/// More than any relay says in kPatience_ns.
constexpr std::uint64_t kFurthestLeap = 4096;

}  // namespace

OtherSide::OtherSide(std::uint64_t relay_id, Role role, std::string session,
                     std::function<void(const std::string&)> report)
    : relay_id_(relay_id), role_(role), session_(std::move(session)), report_(std::move(report)) {}

void OtherSide::tell_of(std::uint64_t relay_id, const std::string& line) {
  if (told_of_.size() == kMaxToldOf ||
      std::find(told_of_.begin(), told_of_.end(), relay_id) != told_of_.end())
    return;
  told_of_.push_back(relay_id);
  report_(line);
}

void OtherSide::hear(const Greeting& greeting) {
  if (greeting.relay_id == relay_id_ || greeting.role == static_cast<std::uint32_t>(role_)) return;
  if (greeting.protocol == kProtocol) return;
  const std::string_view release(greeting.release,
                                 ::strnlen(greeting.release, sizeof greeting.release));
  tell_of(greeting.relay_id, "the relay " + std::string(place_of(other(role_))) +
                                 " is of Stillgrid " + reading::printable(release) +
                                 " and speaks protocol " + std::to_string(greeting.protocol) +
                                 ", this one " + std::to_string(kProtocol) +
                                 ": run the same release on both machines");
}

void OtherSide::follow(std::uint64_t relay_id) {
  if (followed_ != 0)
    report_("another relay " + std::string(place_of(other(role_))) + " takes over session '" +
            session_ + "'");
  followed_ = relay_id;
  clock_ = {};
  status_ = {};
}

bool OtherSide::hear(const Status& status, std::uint64_t now_ns) {
  if (status.relay_id == 0 || status.relay_id == relay_id_ || status.number == 0) return false;
  if (status.relay_id != followed_) {
    if (is_connected_) {
      tell_of(status.relay_id, "two relays " + std::string(place_of(other(role_))) +
                                   " join session '" + session_ +
                                   "': the first is kept to until it falls silent");
      return false;
    }
    follow(status.relay_id);
  }
  // Where nothing newer came for so long, the number before was none: a bit of it was flipped.
  if (is_connected_ &&
      (status.number <= status_.number || status.number - status_.number > kFurthestLeap))
    return false;
  status_ = status;
  if (status.follows == relay_id_ && status.echo_sent_ns != 0) {
    // No more often than clocks drift: the shortest round trip is to be of some seconds.
    if (now_ns >= exchanged_ns_ + kExchange_ns &&
        clock_.add({.sent_ns = status.echo_sent_ns,
                    .other_received_ns = status.echo_received_ns,
                    .other_sent_ns = status.sent_ns,
                    .received_ns = now_ns}))
      exchanged_ns_ = clock_.is_known() ? now_ns : 0;
  } else if (status.follows != 0 && status.follows != relay_id_)
    tell_of(status.relay_id, "the relay " + std::string(place_of(other(role_))) + " of session '" +
                                 session_ + "' keeps to another than this one");
  if (was_connected_ && !is_connected_) {
    ++partitions_;
    longest_silence_ns_ = std::max(longest_silence_ns_, now_ns - heard_ns_);
    report_("the relay " + std::string(place_of(other(role_))) + " is heard again");
  } else if (!was_connected_) {
    report_("joined with the relay " + std::string(place_of(other(role_))));
  }
  heard_ns_ = now_ns;
  is_connected_ = was_connected_ = true;
  return true;
}

void OtherSide::look_at_echo(std::uint64_t now_ns) {
  const bool was_hearing = is_hearing_;
  is_hearing_ = status_.follows == relay_id_ && status_.echo_sent_ns != 0 &&
                now_ns < status_.echo_sent_ns + kPatience_ns + clock_.round_trip_ns();
  if (was_hearing && !is_hearing_ && is_connected_)
    report_("the relay " + std::string(place_of(other(role_))) + " is heard, but hears nothing");
}

void OtherSide::look(std::uint64_t now_ns) {
  look_at_echo(now_ns);
  if (!is_connected_ || now_ns < heard_ns_ + kPatience_ns) return;
  is_connected_ = false;
  report_("nothing is heard of the relay " + std::string(place_of(other(role_))) + " for " +
          std::to_string(kPatience_ns / 1'000'000) + " ms");
}

Status OtherSide::next_status(std::uint64_t now_ns) noexcept {
  Status status{};
  status.relay_id = relay_id_;
  status.number = ++sent_;
  status.sent_ns = now_ns;
  status.follows = followed_;
  status.echo_sent_ns = status_.sent_ns;
  status.echo_received_ns = status_.sent_ns != 0 ? heard_ns_ : 0;
  return status;
}

Greeting OtherSide::greeting() const noexcept {
  Greeting greeting{};
  greeting.relay_id = relay_id_;
  greeting.protocol = kProtocol;
  greeting.role = static_cast<std::uint32_t>(role_);
  std::strncpy(greeting.release, STILLGRID_VERSION, sizeof greeting.release - 1);
  return greeting;
}

}  // namespace stillgrid::scene_relay
