#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "haptic_server/devices/phantom_model.hpp"
#include "haptic_server/devices/plugin_options.hpp"

namespace stillgrid::devices {

/// Whose thread computes the force: the host's, the device's by the host's tick, or the host's
/// beside the device's, which then exerts a force one period late.
enum class Pace { kHost, kDevice, kLate };

/// The options of a simulated device, in the order given. What they throw is one line for the user.
class PhantomOptions {
 public:
  explicit PhantomOptions(std::uint64_t period_ns) : period_ns_(period_ns) {
    recording_.resampling = Resampling::kCubic;  // a hand's velocity does not step
  }

  /// One option. Throws std::runtime_error.
  void set(std::string_view key, std::string_view value);

  /// Everything set so far, put together. Throws where the options do not fit together.
  [[nodiscard]] PhantomSettings settings() const;

  /// Where an instrument passes through a wall, or nothing. Throws where a part of it is given.
  [[nodiscard]] std::optional<Eigen::Vector3d> pivot() const;

  [[nodiscard]] Pace pace() const noexcept { return pace_; }
  [[nodiscard]] bool declares_limits() const noexcept { return declares_limits_; }
  [[nodiscard]] std::uint64_t hold_ns() const noexcept { return hold_ns_; }

 private:
  PhantomProfile profile_ = *phantom_profile("touch");
  HandProfile hand_ = *hand_profile("light");
  std::string path_ = "press";
  RecordingOptions recording_;
  Pace pace_ = Pace::kHost;
  int delay_ticks_ = 0;
  std::uint64_t seed_ = 1;
  bool declares_limits_ = true;
  std::uint64_t hold_ns_ = 0;  // that it stays at its start, whatever pushes
  std::vector<std::pair<std::string, double>> numbers_;  // by key, in the order given
  std::array<std::optional<double>, 3> pivot_m_;         // as configured
  std::uint64_t period_ns_;
};

}  // namespace stillgrid::devices
