#include "sim_server/dynamics/step/budget.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "shared/realtime/processor_time.hpp"

namespace stillgrid::dynamics::budget_test {
namespace {

TEST_CASE(
    "The time of a budget is what its thread computes, whoever asks and however long it waits",
    "[budget]") {
  Budget budget;
  budget.end_within(20'000'000);
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  CHECK_FALSE(budget.is_late());
  bool is_late_elsewhere = true;
  const auto ask = [&] { is_late_elsewhere = budget.is_late(); };
  std::thread(ask).join();
  CHECK_FALSE(is_late_elsewhere);

  const double began_s = realtime::thread_processor_s();
  while (realtime::thread_processor_s() - began_s < 0.03) {
  }
  CHECK(budget.is_late());
  std::thread(ask).join();
  CHECK(is_late_elsewhere);
}

}  // namespace
}  // namespace stillgrid::dynamics::budget_test
