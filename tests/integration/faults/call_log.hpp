#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <ctime>
#include <new>
#include <stdexcept>
#include <string>

namespace stillgrid::integration {

/// What a driver was called for. Read by call_log.py.
enum class Call : std::uint32_t {
  kActivate = 1,
  kWrite = 2,
  kIgnoredWrite = 3,  // after an emergency stop: the force is zero until the next activation
  kDeactivate = 4,
  kEmergencyStop = 5,
  kFaultBegins = 6,
  kFaultEnds = 7,
};

struct CallRecord {
  std::uint64_t time_ns;  // CLOCK_MONOTONIC, when the call came
  std::uint64_t tick_ns;  // what the host said of the time, writes only
  std::uint64_t call;     // Call; 0 until the record is whole
  std::array<double, 3> force_N;
};
static_assert(sizeof(CallRecord) == 48);

/// Opens the file; the records follow it.
struct CallLogHeader {
  std::atomic<std::uint64_t> count;    // of records begun
  std::atomic<std::uint64_t> trigger;  // not 0: the test wants the fault now
  std::array<std::uint64_t, 6> reserved;
};
static_assert(sizeof(CallLogHeader) == 64 && std::atomic<std::uint64_t>::is_always_lock_free);

[[nodiscard]] inline std::uint64_t clock_ns() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000U +
         static_cast<std::uint64_t>(now.tv_nsec);
}

/// What a device was told, in a file that the test has made and mapped, too: it survives every end
/// of the process. Thread: any. Realtime: yes, once open.
class CallLog {
 public:
  /// Takes a file up, whose size is its capacity; goes on behind what stands there. Never unmapped.
  /// Throws std::runtime_error.
  void open(const std::string& file) {
    const int descriptor = ::open(file.c_str(), O_RDWR | O_CLOEXEC);
    struct stat status {};
    const bool is_there = descriptor >= 0 && ::fstat(descriptor, &status) == 0;
    const auto bytes = static_cast<std::size_t>(status.st_size);
    void* const place = is_there && bytes > sizeof(CallLogHeader)
                            ? ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                                     MAP_SHARED | MAP_POPULATE, descriptor, 0)
                            : MAP_FAILED;
    if (descriptor >= 0) ::close(descriptor);
    if (place == MAP_FAILED) throw std::runtime_error("log: '" + file + "': expected room for it");
    header_ = static_cast<CallLogHeader*>(place);
    records_ = reinterpret_cast<CallRecord*>(static_cast<char*>(place) + sizeof(CallLogHeader));
    capacity_ = (bytes - sizeof(CallLogHeader)) / sizeof(CallRecord);
  }

  void add(Call call, std::uint64_t tick_ns = 0, const double* force_N = nullptr) noexcept {
    if (header_ == nullptr) return;
    const std::uint64_t time_ns = clock_ns();
    const std::uint64_t place = header_->count.fetch_add(1, std::memory_order_relaxed);
    if (place >= capacity_) return;  // the count tells
    CallRecord& record = records_[place];
    record.time_ns = time_ns;
    record.tick_ns = tick_ns;
    if (force_N != nullptr) record.force_N = {force_N[0], force_N[1], force_N[2]};
    std::atomic_ref(record.call).store(static_cast<std::uint64_t>(call), std::memory_order_release);
  }

  [[nodiscard]] bool is_triggered() const noexcept {
    return header_ != nullptr && header_->trigger.load(std::memory_order_relaxed) != 0;
  }

 private:
  CallLogHeader* header_ = nullptr;
  CallRecord* records_ = nullptr;
  std::uint64_t capacity_ = 0;
};

}  // namespace stillgrid::integration
