#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "proto/segment_header.hpp"
#include "shared/library/last_error.hpp"

namespace stillgrid::library {

/// Whether a number may be a place, a velocity or a force: no NaN passes. Realtime: yes.
[[nodiscard]] inline bool is_number(double x) noexcept {
  return std::abs(x) <= proto::kLargestNumber;
}

/// Whether all are; else fails, naming the first that is not by its array and index.
[[nodiscard]] inline int check_numbers(std::span<const double> values, const char* name) noexcept {
  bool are_all = true;
  for (const double x : values) are_all &= is_number(x);  // without a branch: as vectors
  if (are_all) return STILLGRID_OK;
  const auto bad = std::find_if_not(values.begin(), values.end(), is_number);
  return fail(STILLGRID_E_ARGUMENT, "%s[%td]: %g: expected a number of at most %g", name,
              bad - values.begin(), *bad, proto::kLargestNumber);
}

/// The same of numbers that must be more than 0, as lengths.
[[nodiscard]] inline int check_positive(std::span<const double> values, const char* name) noexcept {
  const auto bad = std::find_if_not(values.begin(), values.end(), [](double x) {
    return x >= double{std::numeric_limits<float>::min()} && x <= proto::kLargestNumber;
  });
  if (bad == values.end()) return STILLGRID_OK;
  return fail(STILLGRID_E_ARGUMENT, "%s[%td]: %g: expected a number of more than 0", name,
              bad - values.begin(), *bad);
}

}  // namespace stillgrid::library
