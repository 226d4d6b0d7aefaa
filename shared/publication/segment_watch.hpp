#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

#include "shared/publication/segment.hpp"

namespace stillgrid::publication {

/// Keeps a reader attached to a session's segment while its writers come and go.
///
/// View: constructible from a SegmentReader&& (throws SegmentError), with reader() const.
/// poll() is one round of housekeeping; start() runs it at 100 Hz in a thread of its own. The
/// real-time thread calls acquire() once a tick: an old mapping is dropped only after that.
template <class View>
class SegmentWatch {
 public:
  /// Takes up only segments on that clock. report: told of each refusal and loss once, from the
  /// thread that polls.
  SegmentWatch(std::string session, proto::SegmentKind kind, std::uint64_t layout_hash,
               proto::Clock clock, std::function<void(const std::string&)> report)
      : session_(std::move(session)),
        kind_(kind),
        layout_hash_(layout_hash),
        clock_(clock),
        report_(std::move(report)) {}

  /// The mapping to use until the next call, or null while there is none. Unless it may switch, the
  /// one in use stays, whatever has come since. Thread: one, the reader's. Realtime: wait-free.
  [[nodiscard]] const View* acquire(bool may_switch = true) noexcept {
    const View* used = in_use_.load(std::memory_order_relaxed);
    if (!may_switch && used != nullptr) return used;
    const View* view = offered_.load(std::memory_order_acquire);
    in_use_.store(view, std::memory_order_release);
    return view;
  }

  /// Whether the writer of the mapping in use lives, as of the last poll; not so once another has
  /// taken its place. Thread: as acquire(). Realtime: yes.
  [[nodiscard]] bool writer_alive() const noexcept {
    const View* used = in_use_.load(std::memory_order_relaxed);
    const bool is_newest = used == nullptr || used == offered_.load(std::memory_order_relaxed);
    return is_newest && alive_.load(std::memory_order_relaxed);
  }

  /// Looks for a newer segment, asks whether the writer lives, drops what is no longer used.
  /// Thread: any but the real-time one, one at a time.
  void poll() {
    const std::lock_guard only_one(polling_);
    // Only a reader that has taken the new mapping cannot be about to use the old one: it may have
    // loaded offered_ long ago and not yet said so.
    if (old_ && in_use_.load(std::memory_order_acquire) == current_.get()) old_.reset();
    const auto id = segment_id(session_, kind_);
    if (!old_ && id && (!current_ || current_->reader().id() != *id)) attach();
    alive_.store(current_ && current_->reader().writer_alive(), std::memory_order_relaxed);
    if (current_ && current_->reader().is_lost() && reported_lost_ != current_.get()) {
      reported_lost_ = current_.get();
      report_("shared memory " + segment_name(session_, kind_) +
              " was shrunk by another program while in use");
    }
  }

  /// Polls in a thread until destruction.
  void start() {
    thread_ = std::jthread([this](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        poll();
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      }
    });
  }

 private:
  void attach() {
    try {
      auto reader = SegmentReader::open(session_, kind_, layout_hash_);
      if (!reader || !reader->writer_alive()) return;
      if (reader->header().clock != clock_)
        throw SegmentError(clock_refusal(session_, kind_, clock_));
      old_ = std::exchange(current_, std::make_unique<View>(std::move(*reader)));
      offered_.store(current_.get(), std::memory_order_release);
      last_refusal_.clear();
    } catch (const OtherBuildError& error) {
      // What a killed writer of another version left is for the next one to replace.
      if (error.writer_alive) refuse(error.what());
    } catch (const SegmentError& error) {
      refuse(error.what());
    }
  }

  void refuse(const std::string& line) {
    if (last_refusal_ != line) report_(line);
    last_refusal_ = line;
  }

  std::string session_;
  proto::SegmentKind kind_;
  std::uint64_t layout_hash_;
  proto::Clock clock_;
  std::function<void(const std::string&)> report_;
  std::string last_refusal_;

  std::mutex polling_;
  std::unique_ptr<View> current_, old_;
  const View* reported_lost_ = nullptr;
  std::atomic<const View*> offered_ = nullptr, in_use_ = nullptr;
  std::atomic<bool> alive_ = false;
  std::jthread thread_;  // last: joined before what it uses is gone
};

}  // namespace stillgrid::publication
