#include "shared/realtime/rights/realtime_rights.hpp"

#include <grp.h>
#include <pwd.h>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "shared/realtime/realtime_thread.hpp"

namespace stillgrid::realtime {
namespace {

constexpr int kPriority = 80;
constexpr const char* kGroup = "stillgrid";

/// More stack than a tick needs, of drivers too: where a stack grows later, that is a page fault.
[[gnu::noinline]] void touch_stack() {
  constexpr std::size_t kStack = 256 * 1024, kPage = 4096;
  volatile char stack[kStack];
  for (std::size_t i = 0; i < kStack; i += kPage) stack[i] = 0;
  (void)stack[0];
}

/// What a driver starts from this thread is not real-time unless it asks to be.
bool become_fifo() noexcept {
  sched_param wanted{};
  wanted.sched_priority = kPriority;
  return ::sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &wanted) == 0;
}

bool is_member(const group& of, const std::string& user) {
  for (char** name = of.gr_mem; *name != nullptr; ++name)
    if (user == *name) return true;
  return false;
}

bool has_group(gid_t id) {
  std::vector<gid_t> groups(static_cast<std::size_t>(std::max(::getgroups(0, nullptr), 0)));
  const int count = ::getgroups(static_cast<int>(groups.size()), groups.data());
  groups.resize(static_cast<std::size_t>(std::max(count, 0)));
  return ::getegid() == id || std::find(groups.begin(), groups.end(), id) != groups.end();
}

/// What gives a user the rights, from where he stands.
std::string cure() {
  if (::geteuid() == 0) return "root here has no CAP_SYS_NICE or CAP_IPC_LOCK, as in a container";
  const group* const rights = ::getgrnam(kGroup);
  if (rights == nullptr)
    return "'sudo scripts/setup --rights', or the package, makes the group stillgrid";
  if (has_group(rights->gr_gid))
    return "this session began without the limits of its group stillgrid";
  const passwd* const self = ::getpwuid(::geteuid());
  const std::string user = self == nullptr ? "USER" : self->pw_name;
  if (is_member(*rights, user)) return "log in again: the group stillgrid came after this login";
  return "'sudo usermod -aG stillgrid " + user + "', then log in again";
}

}  // namespace

RealtimeRights take_rights(std::optional<int> cpu) {
  RealtimeRights rights;
  rights.is_memory_locked = ::mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
  touch_stack();
  if (become_fifo()) {
    rights.way = RealtimeRights::Way::kFifo;
    rights.priority = kPriority;
  }
  if (cpu && !pin_to_cpu(*cpu)) rights.missing_cpu = cpu;
  return rights;
}

const char* way_name(const RealtimeRights& rights) noexcept {
  switch (rights.way) {
    case RealtimeRights::Way::kFifo:
      return "fifo";
    case RealtimeRights::Way::kRealtimeKit:
      return "rtkit";
    case RealtimeRights::Way::kNone:
      break;
  }
  return "other";
}

std::string missing_line(const RealtimeRights& rights) {
  std::string what;
  const auto add = [&what](const std::string& thing) {
    what += (what.empty() ? "" : " and ") + thing;
  };
  if (rights.way == RealtimeRights::Way::kNone) add("real-time priority");
  if (!rights.is_memory_locked) add("locked memory");
  const bool may_be_granted = !what.empty();
  if (rights.missing_cpu) add("processor " + std::to_string(*rights.missing_cpu));
  if (may_be_granted) what += ": " + cure() + " (docs/realtime.md#rights)";
  return what + (rights.refusal.empty() ? "" : "; RealtimeKit: " + rights.refusal);
}

}  // namespace stillgrid::realtime
