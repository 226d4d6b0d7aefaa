#pragma once

#include <hwy/targets.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <cstdio>
#include <utility>

namespace stillgrid::sim_server {

inline bool said_targets = false;

/// Runs a call with each instruction set that our code holds and this processor has, the plainest
/// last; says once which they are.
template <class Call>
void on_every_target(Call&& call) {
  const struct Restored {
    ~Restored() { hwy::SetSupportedTargetsForTest(0); }
  } restored;
  std::int64_t left = (hwy::SupportedTargets() & HWY_TARGETS) | HWY_STATIC_TARGET;
  for (; left != 0; left &= left - 1) {
    const std::int64_t target = left & -left;
    hwy::SetSupportedTargetsForTest(target);
    INFO(hwy::TargetName(target));
    if (!said_targets) std::printf("runs on %s\n", hwy::TargetName(target));
    call();
  }
  said_targets = true;
}

}  // namespace stillgrid::sim_server
