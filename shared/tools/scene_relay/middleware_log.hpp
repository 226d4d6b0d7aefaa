#pragma once

#include <dds/ddsrt/log.h>

#include <cstdint>
#include <mutex>
#include <string>

namespace stillgrid::scene_relay {

/// What Cyclone DDS says of itself while this lives, as lines of this program instead of its own:
/// the last one belongs to the error that follows, and of packets that it cannot read, which a
/// stranger may send by the thousand, it tells kMax. One in a process. Thread: any.
class MiddlewareLog {
 public:
  static constexpr std::uint64_t kMax = 3;

  MiddlewareLog();
  ~MiddlewareLog();
  MiddlewareLog(const MiddlewareLog&) = delete;
  MiddlewareLog& operator=(const MiddlewareLog&) = delete;
  MiddlewareLog(MiddlewareLog&&) = delete;
  MiddlewareLog& operator=(MiddlewareLog&&) = delete;

  /// From now on lines are told; until then they are only kept.
  void tell();
  /// The last one; empty: none.
  [[nodiscard]] std::string last() const;

 private:
  static void write(void* log, const dds_log_data_t* data);
  void add(std::string line);

  mutable std::mutex mutex_;
  std::string last_;
  bool is_told_ = false;
  std::uint64_t count_ = 0;  // told
};

}  // namespace stillgrid::scene_relay
