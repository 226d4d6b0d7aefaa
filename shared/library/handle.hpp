#pragma once

#include <atomic>

#include "shared/library/last_error.hpp"

namespace stillgrid::library {

/// One call on a handle, by the one thread that is in it. handle: `own` is the object, whose
/// `is_used` tells that a thread is inside; name: for people.
template <class Handle, class Call>
int with_handle(Handle* handle, const char* name, Call&& call) noexcept {
  if (handle == nullptr) return fail(STILLGRID_E_ARGUMENT, "%s: expected a handle, not null", name);
  auto& own = handle->own;
  if (own.is_used.test_and_set(std::memory_order_acquire))
    return fail(STILLGRID_E_THREAD, "%s: another thread is in a call on it", name);
  const int code = guarded([&] { return call(own); });
  own.is_used.clear(std::memory_order_release);
  return code;
}

}  // namespace stillgrid::library
