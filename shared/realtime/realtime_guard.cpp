#include "shared/realtime/realtime_guard.hpp"

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <tuple>

#include "shared/realtime/guard/guard_table.hpp"

namespace stillgrid::realtime {
namespace {

namespace fs = std::filesystem;

/// The preloaded library's table, or null. Looked up by name, so that programs link as ever.
const GuardTable* guard_table() noexcept {
  static const auto* const table =
      static_cast<const GuardTable*>(::dlsym(RTLD_DEFAULT, kGuardTableName));
  return table;
}

[[noreturn]] void refuse(const std::string& why) {
  throw std::runtime_error("--realtime-guard: " + why);
}

}  // namespace

bool realtime_guard_is_loaded() noexcept {
  return guard_table() != nullptr;
}

void require_realtime_guard(char** arguments) {
  if (realtime_guard_is_loaded()) return;
#ifndef __x86_64__
  refuse("only on x86-64");
#endif
  const fs::path program = fs::read_symlink("/proc/self/exe");
  const fs::path library =
      program.parent_path().parent_path() / "lib" / "stillgrid" / "librealtime_guard.so";
  if (!fs::exists(library)) refuse("there is no " + library.string());
  if (library.string().find_first_of(" :") != std::string::npos)
    refuse("the loader takes no blank or colon in " + library.string());
  const char* const others = std::getenv("LD_PRELOAD");
  const std::string preload =
      library.string() + (others == nullptr ? "" : ":") + (others == nullptr ? "" : others);
  // Preloaded in vain, as for a program with rights of its own: do not try for ever.
  if (others != nullptr && std::string_view(others).starts_with(library.string()))
    refuse("the loader did not load " + library.string());
  ::setenv("LD_PRELOAD", preload.c_str(), 1);
  ::execv(program.c_str(), arguments);
  refuse("cannot run " + program.string() + ": " + std::strerror(errno));
}

std::vector<RealtimeViolation> realtime_violations() {
  std::vector<RealtimeViolation> violations;
  if (!realtime_guard_is_loaded()) return violations;
  guard_table()->for_each(
      [](void* list, const GuardEntry& entry) {
        static_cast<std::vector<RealtimeViolation>*>(list)->push_back(
            {entry.call, entry.count, entry.first_tick, entry.first_caller});
      },
      &violations);
  std::sort(violations.begin(), violations.end(), [](const auto& a, const auto& b) {
    return std::tie(a.first_tick, a.call) < std::tie(b.first_tick, b.call);
  });
  return violations;
}

RealtimeSection::RealtimeSection() : guard_(guard_table()) {
  if (guard_ == nullptr) return;
  if (const int code = guard_->enter(); code != 0)
    throw std::system_error(code, std::generic_category(), "the filter of system calls");
}

RealtimeSection::~RealtimeSection() {
  if (guard_ != nullptr) guard_->leave();
}

void RealtimeSection::begin_tick(std::uint64_t tick) noexcept {
  if (guard_ != nullptr) guard_->begin_tick(tick);
}

}  // namespace stillgrid::realtime
