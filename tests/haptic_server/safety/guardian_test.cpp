#include "haptic_server/safety/guardian.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <thread>

#include "shared/realtime/exit_status.hpp"

namespace stillgrid::safety::guardian_test {
namespace {

using namespace std::chrono_literals;

/// What the processes of a guarded program did, as the test sees it.
struct Traces {
  std::atomic<int> tried = 0, released = 0, signal = 0;
};

Traces& new_traces() {
  void* const memory =
      ::mmap(nullptr, sizeof(Traces), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  REQUIRE(memory != MAP_FAILED);
  return *new (memory) Traces;
}

/// work, and one release that succeeds.
int run(Traces& traces, const std::function<int(GuardedState&)>& work) {
  std::fflush(nullptr);  // or each process prints it
  return run_guarded({"device 'test'", work, {[&traces] { ++traces.released; }}});
}

struct Ending {
  const char* name;
  void (*end)();
  int status;
};
constexpr Ending kEndings[] = {
    {"exit", [] { std::_Exit(realtime::kDone); }, realtime::kDeviceFault},
    {"a crash",
     [] {
       std::signal(SIGSEGV, SIG_DFL);  // else the test's own framework has its say
       std::raise(SIGSEGV);
     },
     realtime::kSignalled + SIGSEGV},
    {"a kill", [] { std::raise(SIGKILL); }, realtime::kSignalled + SIGKILL},
};

TEST_CASE("A program that returns ends with its own status and is not released", "[guardian]") {
  Traces& traces = new_traces();
  const int status = GENERATE(0, 1, 4);
  CHECK(run(traces, [status](GuardedState& state) {
          state.has_motors = true;
          state.has_motors = false;
          return status;
        }) == status);
  CHECK(traces.released == 0);
}

TEST_CASE("Motors that were left on are released, however their process ended", "[guardian]") {
  Traces& traces = new_traces();
  for (const Ending& ending : kEndings) {
    INFO(ending.name);
    traces.released = 0;
    CHECK(run(traces, [&ending](GuardedState& state) {
            state.has_motors = true;
            ending.end();
            return 0;
          }) == ending.status);
    CHECK(traces.released == 1);
  }
  CHECK(run(traces, [](GuardedState& state) {
          state.has_motors = true;
          return 0;
        }) == realtime::kDeviceFault);
  CHECK(traces.released == 2);
}

TEST_CASE("Without motors an end that was not meant is told by the status alone", "[guardian]") {
  Traces& traces = new_traces();
  for (const Ending& ending : kEndings) {
    INFO(ending.name);
    CHECK(run(traces, [&ending](GuardedState&) {
            ending.end();
            return 0;
          }) == ending.status);
  }
  CHECK(traces.released == 0);
}

TEST_CASE("Ways to release that fail are followed by the next, up to one that succeeds",
          "[guardian]") {
  Traces& traces = new_traces();
  const auto tried = [&traces](auto rest) {
    return [&traces, rest] {
      ++traces.tried;
      rest();
    };
  };
  std::fflush(nullptr);
  CHECK(run_guarded(
            {"device 'test'",
             [](GuardedState& state) -> int {
               state.has_motors = true;
               std::_Exit(realtime::kDone);
             },
             {tried([] { throw std::runtime_error("the test's own"); }),
              tried([] { std::_Exit(realtime::kDone); }), tried([] { std::raise(SIGKILL); }),
              tried([&traces] { ++traces.released; }), tried([] {})}}) == realtime::kDeviceFault);
  CHECK(traces.tried == 4);
  CHECK(traces.released == 1);
}

TEST_CASE("Motors whose watchdog is silent are released, and one that beats is left alone",
          "[guardian]") {
  Traces& traces = new_traces();
  CHECK(run(traces, [](GuardedState& state) {
          state.has_motors = true;
          for (int beat = 0; beat < 250; ++beat) {
            std::this_thread::sleep_for(10ms);
            ++state.beats;
          }
          state.has_motors = false;
          return 0;
        }) == realtime::kDone);
  CHECK(traces.released == 0);
  CHECK(run(traces, [](GuardedState& state) {
          state.has_motors = true;
          std::this_thread::sleep_for(1h);
          return 0;
        }) == realtime::kDeviceFault);
  CHECK(traces.released == 1);
}

TEST_CASE("A crash that hangs is ended", "[guardian]") {
  Traces& traces = new_traces();
  CHECK(run(traces, [](GuardedState& state) {
          state.has_motors = state.is_crashing = true;
          std::this_thread::sleep_for(1h);
          return 0;
        }) == realtime::kDeviceFault);
  CHECK(traces.released == 1);
}

TEST_CASE("A signal to the guardian reaches the program", "[guardian]") {
  Traces& traces = new_traces();
  CHECK(run(traces, [&traces](GuardedState&) {
          sigset_t set;
          ::sigemptyset(&set);
          ::sigaddset(&set, SIGUSR1);
          ::sigprocmask(SIG_BLOCK, &set, nullptr);
          ::kill(::getppid(), SIGUSR1);
          int number = 0;
          ::sigwait(&set, &number);
          traces.signal = number;
          return 0;
        }) == realtime::kDone);
  CHECK(traces.signal == SIGUSR1);
}

}  // namespace
}  // namespace stillgrid::safety::guardian_test
