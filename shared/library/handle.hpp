#pragma once

#include <sched.h>
#include <unistd.h>

#include <atomic>

#include "shared/library/last_error.hpp"

namespace stillgrid::library {

/// Who made a handle, and whether somebody is inside.
struct HandleUse {
  std::atomic_flag is_used = ATOMIC_FLAG_INIT;
  pid_t process = ::getpid();
};

/// One call on a handle, by the one thread that is in it. handle: `own` is the object, `use`
/// who may be inside; name: for people.
template <class Handle, class Call>
int with_handle(Handle* handle, const char* name, Call&& call) noexcept {
  if (handle == nullptr) return fail(STILLGRID_E_ARGUMENT, "%s: expected a handle, not null", name);
  if (handle->use.process != ::getpid())
    return fail(STILLGRID_E_ORDER, "%s: made by process %d; expected no call of a fork's child",
                name, static_cast<int>(handle->use.process));
  if (handle->use.is_used.test_and_set(std::memory_order_acquire))
    return fail(STILLGRID_E_THREAD, "%s: another thread is in a call on it", name);
  const int code = guarded([&] { return call(handle->own); });
  handle->use.is_used.clear(std::memory_order_release);
  return code;
}

/// Frees a handle once nobody is inside any more; of a fork's child nothing.
template <class Handle>
void close_handle(Handle* handle) noexcept {
  if (handle == nullptr || handle->use.process != ::getpid()) return;
  while (handle->use.is_used.test_and_set(std::memory_order_acquire)) ::sched_yield();
  delete handle;
}

}  // namespace stillgrid::library
