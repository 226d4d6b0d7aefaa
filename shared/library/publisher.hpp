#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "proto/stillgrid.h"
#include "shared/library/body_pushes.hpp"
#include "shared/publication/moving_records.hpp"
#include "shared/publication/session.hpp"
#include "shared/realtime/periodic_timer.hpp"

namespace stillgrid::library {

/// A session of an engine's, as proto/stillgrid.h has it: each member function is the call of its
/// name, of arguments that are not null. Thread: one at a time.
class Publisher {
 public:
  /// Takes the session. Throws SegmentError.
  Publisher(const publication::SessionSpec& spec, std::span<const publication::HandScene> hands);
  /// Ends the session for its peers.
  ~Publisher();
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;
  Publisher(Publisher&&) = delete;
  Publisher& operator=(Publisher&&) = delete;

  int wait(std::uint64_t& time_ns);
  int set_shapes(const stillgrid_shapes& shapes);
  int set_spheres(std::uint32_t count, const double* positions_m, const double* velocities_m_s);
  int set_responses(std::span<const stillgrid_response> responses);
  int find_pushes(double step_s, std::span<stillgrid_push> pushes, std::uint32_t& count);
  int publish(std::uint64_t state_time_ns);
  int take_tool(std::uint32_t hand, stillgrid_tool& tool);

 private:
  struct Hand {
    std::uint64_t epoch = 0;         // the tool's segment that the path is from
    std::uint64_t told_tool_ns = 0;  // the newest sample in the state
    double work_J = 0.0;
  };
  using Impulse = std::pair<std::uint32_t, local::Twist>;  // N s, N m s
  [[nodiscard]] bool is_virtual() const noexcept { return spec_.clock == proto::Clock::kVirtual; }
  [[nodiscard]] bool peers_ended() noexcept;
  int wait_in_virtual_time(std::uint64_t& time_ns);
  void follow_tools();
  void end_step() noexcept;
  void add_impulses() noexcept;
  [[nodiscard]] publication::SnapshotState state_at(std::uint64_t state_ns);

  publication::SessionSpec spec_;
  double period_s_;
  publication::Session session_;
  std::atomic<bool> never_ = false;
  std::optional<publication::LockstepPeers> peers_;
  std::optional<realtime::PeriodicTimer> timer_;
  publication::MovingRecords moving_;
  std::uint64_t published_ns_ = 0;                         // the last state shown, in real time
  std::vector<local::GivenBody> given_, bodies_, before_;  // by number: being checked, of this
                                                           // state and of the one before
  BodyPushes pushes_;
  std::vector<Hand> hands_;
  std::vector<HandPath> paths_;  // one a hand
  std::uint32_t material_count_;
  bool gives_inertia_;
  std::optional<std::uint64_t> state_ns_;  // of the state that was set, once one was published
  double step_s_, stretch_ = 1.0;  // of the last pushes; of the path, where time fell behind
  std::uint64_t time_ns_ = 0;      // of the state that wait() asked for
  bool waited_ = false;            // and it is not published yet
  std::vector<local::GivenBody> shown_, next_shown_;  // the last snapshot's, explained over the
                                                      // time since the one before
  std::vector<Impulse> impulses_;                     // since it, by number of body
  double shown_s_ = 0.0;                              // and the steps' time
  bool is_shown_ = false;                             // the state that was set was published
  bool is_declared_ = false, is_placed_ = false, has_pushes_ = false;
};

}  // namespace stillgrid::library
