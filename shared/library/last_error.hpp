#pragma once

#include <exception>

#include "proto/stillgrid.h"

namespace stillgrid::library {

/// Keeps the line for stillgrid_last_error() and returns the code. Allocates nothing; a line is cut
/// at 511 characters.
[[gnu::format(printf, 2, 3)]] int fail(int code, const char* format, ...) noexcept;

/// The same of an exception that is under way, by its kind. Pre: called in a catch clause.
int fail_with_current() noexcept;

/// What a call does, with no exception leaving it.
template <class Call>
int guarded(Call&& call) noexcept {
  try {
    return call();
  } catch (...) {
    return fail_with_current();
  }
}

}  // namespace stillgrid::library
