#include <catch2/catch.hpp>
#include <string>

#include "tests/laboratory/lab_cell.hpp"

namespace stillgrid::laboratory::local_bears_test {
namespace {

/// Half of what a rigid wall bears at 1 kHz (1.1), for the light device and with the hand.
constexpr double kHalfWallLight_N_per_m = 5042.0;
constexpr double kHalfWallHand_N_per_m = 7464.0;

/// 33 ms, 30 % jitter, 30 um encoders; cost: of a step, of the period.
bool is_stable(const std::string& body, const std::string& device, const std::string& transition,
               double cost) {
  LabCell cell;
  cell.scene = body;
  cell.device = device;
  cell.transition = transition;
  cell.period_s = 0.033;
  cell.latency_share = cost;
  cell.jitter = 0.3;
  const double stiffness_N_per_m =
      device == "light" ? kHalfWallLight_N_per_m : kHalfWallHand_N_per_m;
  return verdict_of(cell, stiffness_N_per_m) == Verdict::kStable;
}

}  // namespace

TEST_CASE("With local what gives way bears half of what a rigid wall bears at 1 kHz") {
  for (const char* const device : {"light", "hand"})
    for (const char* const body : {"free:0.05", "free:0.1", "chain", "block"}) {
      CAPTURE(device, body);
      CHECK(is_stable(body, device, "local", 0.1));
    }
}

TEST_CASE("The linear transition does not bear it with the hand") {
  for (const char* const body : {"free:0.1", "chain"}) {
    CAPTURE(body);
    CHECK_FALSE(is_stable(body, "hand", "linear", 0.1));
  }
}

TEST_CASE("Late snapshots lose a chain in the hand by hold and by linear, not by local") {
  CHECK_FALSE(is_stable("chain", "hand", "hold", 1.0));
  CHECK_FALSE(is_stable("chain", "hand", "linear", 1.0));
  CHECK(is_stable("chain", "hand", "local", 1.0));
}

}  // namespace stillgrid::laboratory::local_bears_test
