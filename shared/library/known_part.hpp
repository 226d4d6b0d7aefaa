#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "shared/library/last_error.hpp"

namespace stillgrid::library {

/// Copies a struct of the caller's as far as both sides know it; what lies outside is 0. Fails
/// where it is null, or has no size that can be one. first: the size of its first version, which
/// every caller has.
template <class Struct>
int take_known(const Struct* given, const char* name, std::size_t first, Struct& known) noexcept {
  known = {};
  if (given == nullptr) return fail(STILLGRID_E_ARGUMENT, "%s: expected a struct, not null", name);
  if (given->struct_size < first)
    return fail(STILLGRID_E_ARGUMENT, "%s.struct_size: %u: expected sizeof, %zu or more", name,
                given->struct_size, first);
  std::memcpy(&known, given, std::min<std::size_t>(given->struct_size, sizeof known));
  return STILLGRID_OK;
}

/// Writes a struct back as far as the caller knows it.
template <class Struct>
void give_known(const Struct& known, Struct* given) noexcept {
  const std::uint32_t size = given->struct_size;
  std::memcpy(given, &known, std::min<std::size_t>(size, sizeof known));
  given->struct_size = size;
}

}  // namespace stillgrid::library
