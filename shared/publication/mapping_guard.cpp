#include "shared/publication/mapping_guard.hpp"

#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <mutex>
#include <string>
#include <utility>

#include "shared/publication/segment_files.hpp"

namespace stillgrid::publication {
namespace {

constexpr std::size_t kNone = SIZE_MAX;

/// Read in the handler: atomics only. `begin` is stored last and cleared first.
struct Entry {
  std::atomic<bool> is_taken = false, is_lost = false;
  std::atomic<std::uintptr_t> begin = 0;
  std::atomic<std::size_t> size_bytes = 0;
  std::atomic<int> protection = PROT_READ;
};
static_assert(std::atomic<std::uintptr_t>::is_always_lock_free);

std::array<Entry, MappingGuard::kMax> entries;
struct sigaction action_before;

/// Async-signal-safe. Whether the address was in a guarded mapping, which is then all zeros.
bool replace_mapping_of(std::uintptr_t address) {
  for (Entry& entry : entries) {
    const std::uintptr_t begin = entry.begin.load();
    const std::size_t size_bytes = entry.size_bytes;
    const int protection = entry.protection;
    if (begin == 0 || address < begin || address - begin >= size_bytes) continue;
    if (entry.begin.load() != begin) continue;  // another took the entry: size may not be begin's
    // As system calls: POSIX lists neither among what a handler may call.
    const auto replace = [&] {
      return ::syscall(SYS_mmap, begin, size_bytes, protection,
                       MAP_FIXED | MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) != -1;
    };
    bool is_replaced = replace();
    if (!is_replaced && errno == EAGAIN)  // the limit of locked memory: give back what is lost
      is_replaced = ::syscall(SYS_munlock, begin, size_bytes) == 0 && replace();
    entry.is_lost.store(is_replaced, std::memory_order_release);
    return is_replaced;
  }
  return false;
}

void on_bus_error(int signal, siginfo_t* info, void* context) {
  const int errno_before = errno;
  const bool is_ours = replace_mapping_of(reinterpret_cast<std::uintptr_t>(info->si_addr));
  errno = errno_before;
  if (is_ours) return;
  if ((action_before.sa_flags & SA_SIGINFO) != 0)
    return action_before.sa_sigaction(signal, info, context);
  ::sigaction(SIGBUS, &action_before, nullptr);  // the access is repeated, and ends as it must
}

void install_handler() {
  static std::once_flag once;
  std::call_once(once, [] {
    struct sigaction action {};
    action.sa_sigaction = on_bus_error;
    action.sa_flags = SA_SIGINFO;
    ::sigemptyset(&action.sa_mask);
    ::sigaction(SIGBUS, &action, &action_before);
  });
}

}  // namespace

MappingGuard::MappingGuard(std::span<const std::byte> mapping, Access access) : entry_(kNone) {
  install_handler();
  for (std::size_t i = 0; i < entries.size() && entry_ == kNone; ++i)
    if (!entries[i].is_taken.exchange(true)) entry_ = i;
  if (entry_ == kNone)
    throw SegmentError("more than " + std::to_string(kMax) + " segments at a time");
  Entry& entry = entries[entry_];
  entry.is_lost = false;
  entry.size_bytes = mapping.size();
  entry.protection = access == Access::kWrite ? PROT_READ | PROT_WRITE : PROT_READ;
  entry.begin.store(reinterpret_cast<std::uintptr_t>(mapping.data()));
}

MappingGuard::MappingGuard(MappingGuard&& other) noexcept
    : entry_(std::exchange(other.entry_, kNone)) {}

MappingGuard::~MappingGuard() {
  if (entry_ == kNone) return;
  entries[entry_].begin.store(0);
  entries[entry_].is_taken.store(false, std::memory_order_release);
}

bool MappingGuard::is_lost() const noexcept {
  return entries[entry_].is_lost.load(std::memory_order_acquire);
}

}  // namespace stillgrid::publication
