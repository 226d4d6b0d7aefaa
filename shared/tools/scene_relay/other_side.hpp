#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "shared/tools/scene_relay/clock_offset.hpp"
#include "shared/tools/scene_relay/messages.hpp"

namespace stillgrid::scene_relay {

/// The relay on the other machine: which one, whether it is heard, and how its clock runs.
///
/// Of several that join one session the first is kept to for as long as it is heard; the others
/// are told of in a line each, the first sixteen of them. One that speaks another protocol is too,
/// and is not heard.
/// Thread: one.
class OtherSide {
 public:
  /// Silence after which another may take its place.
  static constexpr std::uint64_t kPatience_ns = 500'000'000;

  /// report: told one line. Pre: relay_id is not 0.
  OtherSide(std::uint64_t relay_id, Role role, std::string session,
            std::function<void(const std::string&)> report);

  void hear(const Greeting& greeting);
  /// Whether it is that of the relay that is kept to, newer than those before.
  bool hear(const Status& status, std::uint64_t now_ns);

  /// Notes the time: a silence that begins is told. Called often.
  void look(std::uint64_t now_ns);

  /// Whether messages of that relay count.
  [[nodiscard]] bool is_followed(std::uint64_t relay_id) const noexcept {
    return followed_ != 0 && relay_id == followed_;
  }
  [[nodiscard]] std::uint64_t followed() const noexcept { return followed_; }
  [[nodiscard]] bool is_connected() const noexcept { return is_connected_; }
  /// Whether it says that it hears this one. A link may lose what goes one way alone.
  [[nodiscard]] bool is_hearing() const noexcept { return is_hearing_; }
  [[nodiscard]] const ClockOffset& clock() const noexcept { return clock_; }
  /// The last one heard.
  [[nodiscard]] const Status& status() const noexcept { return status_; }
  [[nodiscard]] std::uint64_t partitions() const noexcept { return partitions_; }
  [[nodiscard]] std::uint64_t longest_silence_ns() const noexcept { return longest_silence_ns_; }
  /// Until the clock is known exchanges follow one another faster.
  [[nodiscard]] std::uint64_t status_period_ns() const noexcept {
    return clock_.is_known() ? 100'000'000 : 20'000'000;
  }

  /// What to send now; segment and keyframe are the caller's to fill in.
  [[nodiscard]] Status next_status(std::uint64_t now_ns) noexcept;
  [[nodiscard]] Greeting greeting() const noexcept;

 private:
  void look_at_echo(std::uint64_t now_ns);
  void follow(std::uint64_t relay_id);
  void tell_of(std::uint64_t relay_id, const std::string& line);

  static constexpr std::size_t kMaxToldOf = 16;

  std::uint64_t relay_id_;
  Role role_;
  std::string session_;
  std::function<void(const std::string&)> report_;
  ClockOffset clock_;
  Status status_{};
  std::uint64_t followed_ = 0, heard_ns_ = 0, exchanged_ns_ = 0, sent_ = 0;
  std::vector<std::uint64_t> told_of_;
  bool is_connected_ = false, was_connected_ = false, is_hearing_ = false;
  std::uint64_t partitions_ = 0, longest_silence_ns_ = 0;
};

}  // namespace stillgrid::scene_relay
