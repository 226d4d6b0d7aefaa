#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string_view>

#include "proto/stillgrid.h"
#include "tests/fuzz/fuzz_input.hpp"

namespace stillgrid::fuzz {

inline constexpr std::uint32_t kRoom = 24;  // in every array; capacities are less

struct Numbers {
  std::array<double, std::size_t{36} * kRoom> doubles{};
  std::array<std::uint32_t, kRoom> integers{};
};

inline double number(FuzzInput& input) {
  constexpr std::array<double, 16> kNumbers{0.0,
                                            1.0,
                                            -1.0,
                                            1e-3,
                                            0.01,
                                            0.03,
                                            0.5,
                                            2.0,
                                            1e-9,
                                            1e6,
                                            1e30,
                                            -1e6,
                                            std::numeric_limits<double>::quiet_NaN(),
                                            std::numeric_limits<double>::infinity(),
                                            5e-324,
                                            0.005};
  const auto which = input.take<std::uint8_t>();
  return which < 240 ? kNumbers[which % 16] : input.take<double>();
}

template <std::size_t N>
inline void fill(FuzzInput& input, double (&values)[N]) {
  for (double& value : values) value = number(input);
}

inline Numbers numbers(FuzzInput& input) {
  Numbers some;
  const auto count = input.take<std::uint8_t>();
  for (std::size_t i = 0; i < some.doubles.size(); ++i)
    some.doubles[i] = i < count ? number(input) : 0.01 * static_cast<double>(i % 7 + 1);
  for (std::uint32_t& value : some.integers)
    value = count < 200 ? 0 : input.take<std::uint32_t>() % 5;
  return some;
}

template <class T>
T* perhaps(FuzzInput& input, T* there) {
  return input.take<std::uint8_t>() == 255 ? nullptr : there;
}

inline std::uint32_t size_of(FuzzInput& input, std::size_t right) {
  const auto which = input.take<std::uint8_t>();
  return which < 240 ? static_cast<std::uint32_t>(right) : input.take<std::uint32_t>() % 512;
}

inline void check(int code) {
  require(code >= STILLGRID_E_FAULT + 1 && code <= STILLGRID_AGAIN, "a code is a known one");
  if (code >= 0) return;
  const std::string_view line = stillgrid_last_error();
  require(!line.empty() && line.size() < 512, "a failure says why");
  require(line.find_first_of("\n\r") == std::string_view::npos, "in one line");
}

/// A call that fills in a struct in which room lies behind what the caller may say that it knows.
template <class Struct, class Call>
void check_filled(FuzzInput& input, Struct given, Call&& call) {
  struct {
    Struct known;
    std::array<std::byte, 512> behind;
  } now{given, {}};
  now.known.struct_size = size_of(input, sizeof(Struct));
  const auto before = now;
  const int code = call(perhaps(input, &now.known));
  check(code);
  require(code == STILLGRID_OK || std::memcmp(&now, &before, sizeof now) == 0,
          "a call that failed writes nothing");
  require(now.behind == before.behind, "nothing is written behind what is known");
}

}  // namespace stillgrid::fuzz
