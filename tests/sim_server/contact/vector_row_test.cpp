#include "sim_server/contact/vector_row.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <csignal>
#include <vector>

#include "tests/sim_server/unkind_heap.hpp"

namespace stillgrid::contact::vector_row_test {
namespace {

struct alignas(64) Numbers {
  std::array<double, 6 * kLanes> of{};
};

TEST_CASE("Only multiples of 64 bytes take the widest vector of doubles", "[vector_row]") {
  Numbers numbers;
  for (std::size_t i = 0; i < numbers.of.size(); ++i)
    CHECK(is_aligned_lanes(numbers.of.data() + i) == (i % kLanes == 0));
  const auto* const floats = reinterpret_cast<const float*>(numbers.of.data());
  for (std::size_t i = 0; i < 4 * kLanes; ++i)
    CHECK(is_aligned_lanes(floats + i) == (i % kLanes == 0));
}

TEST_CASE("The heap of these tests is as unkind as it may be", "[vector_row]") {
  const std::size_t offset_B = GENERATE(0U, 16U, 32U, 48U);
  struct alignas(32) Aligned32 {
    double of[4];
  };
  const auto past_64 = [](const auto& numbers) {
    return reinterpret_cast<std::uintptr_t>(numbers.data()) % 64;
  };
  const sim_server::UnkindHeap heap(offset_B);
  CHECK(past_64(std::vector<double>(9)) == offset_B);
  CHECK(past_64(std::vector<Aligned32>(3)) == offset_B / 32 * 32);
  CHECK(past_64(std::vector<Numbers>(2)) == 0);
}

#ifndef NDEBUG
/// Whether a call is stopped by an assertion, in a process of its own.
template <class Call>
bool is_stopped(Call&& call) {
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGABRT, SIG_DFL);
    (void)dup2(open("/dev/null", O_WRONLY), STDERR_FILENO);
    call();
    _exit(0);
  }
  int status = 0;
  return waitpid(child, &status, 0) == child && WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT;
}

TEST_CASE("An access that the widest vector could not make is stopped on any processor",
          "[vector_row]") {
  Numbers numbers;
  double* const first = numbers.of.data();
  const VectorRow<double> row(first + kLanes, numbers.of);
  const auto at = [&](std::ptrdiff_t shift, std::size_t i) {
    return is_stopped([&] { (void)(row + shift).at(i); });
  };
  const auto aligned = [&](std::ptrdiff_t shift, std::size_t i) {
    return is_stopped([&] { (void)(row + shift).aligned(i); });
  };
  CHECK_FALSE(at(-8, 0));
  CHECK(at(-9, 0));
  CHECK_FALSE(at(0, 39));
  CHECK(at(0, 40));
  CHECK_FALSE(at(0, 38));
  CHECK(at(1, 38));  // of two lanes it would stay inside
  CHECK_FALSE(is_stopped([&] { (void)(row + -8).one(47); }));
  CHECK(is_stopped([&] { (void)(row + -8).one(48); }));
  CHECK_FALSE(is_stopped([&] { (void)row.at(8, 2); }));
  CHECK(is_stopped([&] { (void)row.at(16, 2); }));
  CHECK_FALSE(aligned(0, 2));
  CHECK_FALSE(aligned(8, 0));
  const std::ptrdiff_t off = GENERATE(1, 2, 4, 6);
  CHECK(aligned(off, 0));  // 16, 32 or 48 bytes past, where narrower vectors are aligned
  CHECK(aligned(off, 2));
}
#endif

}  // namespace
}  // namespace stillgrid::contact::vector_row_test
