#include "haptic_server/devices/haply_echo.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

namespace stillgrid::devices::haply_echo_test {
namespace {

using Verdict = HaplyEcho::Verdict;

/// Sends a force along z and hears one, so many times. The verdict on the last.
Verdict tell(HaplyEcho& echo, double sent_N, double heard_N, int times) {
  Verdict verdict = Verdict::kAgrees;
  for (int n = 0; n < times; ++n) {
    echo.sent({0.0, 0.0, sent_N});
    verdict = echo.heard({0.0, 0.0, heard_N});
  }
  return verdict;
}

TEST_CASE("A force that is told as it was sent agrees, also three messages late", "[haply]") {
  HaplyEcho echo;
  for (int n = 0; n < 1000; ++n) {
    echo.sent({0.0, 0.0, 0.01 * n});
    REQUIRE(echo.heard({0.0, 0.0, 0.01 * std::max(0, n - 3)}) == Verdict::kAgrees);
  }
}

TEST_CASE("Another force than was sent is found in twenty replies and not in nineteen", "[haply]") {
  HaplyEcho echo;
  CHECK(tell(echo, 1.0, 1.0, 10) == Verdict::kAgrees);
  CHECK(tell(echo, 1.0, 2.0, HaplyEcho::kPatience - 1) == Verdict::kAgrees);
  CHECK(tell(echo, 1.0, 2.0, 1) == Verdict::kDiffers);
}

TEST_CASE("A force where none was sent differs, and one that is lost later is not 'ignored'",
          "[haply]") {
  HaplyEcho echo;
  CHECK(tell(echo, 0.0, 0.5, HaplyEcho::kPatience) == Verdict::kDiffers);
  HaplyEcho other;
  CHECK(tell(other, 1.0, 1.0, 10) == Verdict::kAgrees);
  CHECK(tell(other, 1.0, 0.0, HaplyEcho::kPatience + 4) == Verdict::kDiffers);
}

TEST_CASE("A service that never applies a force ignores it, which pauses do not hide", "[haply]") {
  HaplyEcho echo;
  CHECK(tell(echo, 1.0, 0.0, HaplyEcho::kPatience / 2) == Verdict::kAgrees);
  CHECK(tell(echo, 0.0, 0.0, 100) == Verdict::kAgrees);
  CHECK(tell(echo, 1.0, 0.0, HaplyEcho::kPatience) == Verdict::kIgnored);
}

}  // namespace
}  // namespace stillgrid::devices::haply_echo_test
