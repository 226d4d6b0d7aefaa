#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace stillgrid::devices {

/// Compares the force that the service says it applies with those that it was sent last: a name
/// that it does not know, a scale or somebody else's force shows here and nowhere else.
class HaplyEcho {
 public:
  /// So many replies in a row may differ: the service is allowed its own ticks.
  static constexpr int kPatience = 20;
  static constexpr double kTolerance_N = 0.1;
  static constexpr double kTolerance = 0.1;  // share of the force, beside it

  enum class Verdict {
    kAgrees,   // or not yet sure
    kIgnored,  // no force at all, since the beginning: it does not know our name for it
    kDiffers,
  };

  /// The force that was sent. Pre: finite.
  void sent(const Eigen::Vector3d& force_N) noexcept;

  /// The force that the reply tells. It agrees where it lies, with the tolerance, in the box round
  /// the last four that were sent. While next to nothing is sent and told, nothing is learnt.
  [[nodiscard]] Verdict heard(const Eigen::Vector3d& force_N) noexcept;

  /// The force that was sent last.
  [[nodiscard]] const Eigen::Vector3d& last_sent_N() const noexcept { return sent_N_[newest_]; }

  /// Forgets all: another name is tried.
  void reset() noexcept { *this = {}; }

 private:
  std::array<Eigen::Vector3d, 4> sent_N_ = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
                                            Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  std::size_t newest_ = 0;
  int differing_ = 0;
  bool has_confirmed_ = false;  // any force
};

}  // namespace stillgrid::devices
