#include "shared/realtime/realtime_guard.hpp"

#include <fcntl.h>
#include <malloc.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "shared/realtime/periodic_timer.hpp"

namespace stillgrid::realtime::realtime_guard_test {

// The library under test is linked, not preloaded: it stands before libc all the same.
namespace {

using Counts = std::map<std::string, std::uint64_t>;

bool is_skipped() {
  if (realtime_guard_is_loaded()) return false;
  WARN("skipped: a sanitizer or this processor keeps the guard from being built");
  return true;
}

Counts counts() {
  Counts counts;
  for (const RealtimeViolation& violation : realtime_violations())
    counts[violation.call] = violation.count;
  return counts;
}

Counts since(const Counts& before) {
  Counts now = counts();
  for (const auto& [call, count] : before)
    if ((now[call] -= count) == 0) now.erase(call);
  return now;
}

/// Keeps the compiler from leaving an allocation out.
void use(void* memory) {
  asm volatile("" : : "r"(memory) : "memory");
}

/// Runs work in a thread of its own, whose filter ends with it: what the section counted.
Counts counted(const std::function<void()>& work) {
  const Counts before = counts();
  std::thread([&] {
    void* const first = std::malloc(1);  // maps the thread's arena
    use(first);
    std::free(first);
    const RealtimeSection section;
    work();
  }).join();
  return since(before);
}

const timespec kPast{};

struct Kind {
  const char* call;
  std::function<void()> work;
};

std::vector<Kind> allocations() {
  static void* memory = nullptr;
  return {{"malloc", [] { use(memory = std::malloc(100)); }},
          {"free", [] { std::free(memory); }},
          {"malloc", [] { use(memory = ::operator new(100)); }},
          {"free", [] { ::operator delete(memory); }},
          {"calloc", [] { use(memory = std::calloc(10, 10)); }},
          {"realloc", [] { use(memory = std::realloc(memory, 120)); }},
          {"aligned_alloc", [] { use(memory = std::aligned_alloc(64, 128)); }},
          {"memalign", [] { use(memory = ::memalign(64, 128)); }},
          {"posix_memalign", [] {
             if (::posix_memalign(&memory, 64, 128) != 0) std::abort();
           }}};
}

std::vector<Kind> locks() {
  static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
  static pthread_rwlock_t rwlock = PTHREAD_RWLOCK_INITIALIZER;
  static std::mutex standard_mutex;
  static sem_t semaphore;
  static const bool is_made = ::sem_init(&semaphore, 0, 1) == 0;
  CHECK(is_made);
  const auto unlock = [] { ::pthread_mutex_unlock(&mutex); };
  const auto unlock_rw = [] { ::pthread_rwlock_unlock(&rwlock); };
  return {{"pthread_mutex_lock", [=] { ::pthread_mutex_lock(&mutex), unlock(); }},
          {"pthread_mutex_lock", [] { const std::lock_guard lock(standard_mutex); }},
          {"pthread_mutex_trylock", [=] { ::pthread_mutex_trylock(&mutex), unlock(); }},
          {"pthread_mutex_timedlock", [=] { ::pthread_mutex_timedlock(&mutex, &kPast), unlock(); }},
          {"pthread_rwlock_rdlock", [=] { ::pthread_rwlock_rdlock(&rwlock), unlock_rw(); }},
          {"pthread_rwlock_wrlock", [=] { ::pthread_rwlock_wrlock(&rwlock), unlock_rw(); }},
          {"pthread_rwlock_tryrdlock", [=] { ::pthread_rwlock_tryrdlock(&rwlock), unlock_rw(); }},
          {"pthread_rwlock_trywrlock", [=] { ::pthread_rwlock_trywrlock(&rwlock), unlock_rw(); }},
          {"sem_wait", [] { ::sem_wait(&semaphore), ::sem_post(&semaphore); }},
          {"sem_timedwait", [] { ::sem_timedwait(&semaphore, &kPast), ::sem_post(&semaphore); }}};
}

std::vector<Kind> system_calls() {
  return {{"getpid", [] { ::getpid(); }},
          {"sched_yield", [] { ::sched_yield(); }},
          {"openat", [] { ::open("/absent", O_RDONLY); }},
          {"write",
           [] {
             if (::write(-1, "", 1) != -1) std::abort();
           }},
          {"clock_nanosleep", [] { std::this_thread::sleep_for(std::chrono::nanoseconds(1)); }},
          {"system call 400", [] { ::syscall(400); }},
          {"system call above 511", [] { ::syscall(100'000); }}};
}

}  // namespace

TEST_CASE("Each kind of call that may block is counted once and by its name", "[realtime_guard]") {
  if (is_skipped()) return;
  for (const auto& kinds : {allocations(), locks(), system_calls()}) {
    for (const Kind& kind : kinds) {
      CAPTURE(kind.call);
      CHECK(counted(kind.work) == Counts{{kind.call, 1}});
    }
  }
}

TEST_CASE("A wait for a condition is counted and takes the condition of today's layout",
          "[realtime_guard]") {
  if (is_skipped()) return;
  pthread_cond_t condition = PTHREAD_COND_INITIALIZER;
  pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
  int result = 0;
  const Counts found = counted([&] {
    ::pthread_mutex_lock(&mutex);
    result = ::pthread_cond_timedwait(&condition, &mutex, &kPast);
    ::pthread_mutex_unlock(&mutex);
  });
  CHECK(result == ETIMEDOUT);
  CHECK(found.at("pthread_cond_timedwait") == 1);
}

TEST_CASE("What no section makes is not counted", "[realtime_guard]") {
  if (is_skipped()) return;
  const Counts before = counts();
  for (const auto& kinds : {allocations(), locks(), system_calls()})
    for (const Kind& kind : kinds) kind.work();
  CHECK(since(before).empty());
}

TEST_CASE("Of two threads only the one inside a section is counted", "[realtime_guard]") {
  if (is_skipped()) return;
  std::atomic<bool> is_inside = false, is_done = false;
  std::thread other([&] {
    while (!is_inside) {
    }
    for (const auto& kinds : {allocations(), locks(), system_calls()})
      for (const Kind& kind : kinds) kind.work();
    is_done = true;
  });
  const Counts found = counted([&] {
    is_inside = true;
    while (!is_done) {
    }
  });
  other.join();
  CHECK(found.empty());
}

TEST_CASE("What cannot block is no violation", "[realtime_guard]") {
  if (is_skipped()) return;
  const long page_bytes = ::sysconf(_SC_PAGESIZE);
  const auto size = static_cast<std::size_t>(page_bytes);
  void* const page = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  PeriodicTimer timer(1'000'000);
  void* placed = nullptr;
  const Counts found = counted([&] {
    std::free(nullptr);
    timer.wait();
    timespec now{};
    ::syscall(SYS_clock_gettime, CLOCK_MONOTONIC, &now);
    // As a handler of SIGBUS puts pages in place of those that were cut off.
    placed =
        ::mmap(page, size, PROT_READ | PROT_WRITE, MAP_FIXED | MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  });
  CHECK(placed == page);
  CHECK(found.empty());
  ::munmap(page, size);
}

TEST_CASE("A counted system call gives its result or its error", "[realtime_guard]") {
  if (is_skipped()) return;
  std::array<int, 2> ends{};
  REQUIRE(::pipe(ends.data()) == 0);
  std::array<char, 8> text{};
  ssize_t written = 0, read = 0, failed = 0;
  int code = 0;
  pid_t process = 0;
  counted([&] {
    written = ::write(ends[1], "law", 3);
    read = ::read(ends[0], text.data(), text.size());
    failed = ::write(-1, "", 1);
    code = errno;
    process = ::getpid();
  });
  CHECK(written == 3);
  CHECK(read == 3);
  CHECK(std::string(text.data()) == "law");
  CHECK(failed == -1);
  CHECK(code == EBADF);
  CHECK(std::to_string(process) == std::filesystem::read_symlink("/proc/self").string());
  for (const int end : ends) ::close(end);
}

TEST_CASE("Threads, processes and signal masks come about as without the guard",
          "[realtime_guard]") {
  if (is_skipped()) return;
  int status = -1;
  bool is_blocked = false, is_open_again = true, thread_ran = false;
  const Counts found = counted([&] {
    sigset_t set, now;
    ::sigemptyset(&set);
    ::sigaddset(&set, SIGUSR1);
    ::pthread_sigmask(SIG_BLOCK, &set, nullptr);
    ::pthread_sigmask(SIG_BLOCK, nullptr, &now);
    is_blocked = ::sigismember(&now, SIGUSR1) == 1;
    ::pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
    ::pthread_sigmask(SIG_BLOCK, nullptr, &now);
    is_open_again = ::sigismember(&now, SIGUSR1) == 0;
    std::thread([&] { thread_ran = ::getpid() > 0; }).join();
    const pid_t child = ::fork();
    if (child == 0) ::_exit(::getpid() > 0 ? 7 : 8);
    ::waitpid(child, &status, 0);
  });
  CHECK(is_blocked);
  CHECK(is_open_again);
  CHECK(thread_ran);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 7);
  CHECK(found.at("pthread_create") == 1);
  CHECK(found.at("clone") == 1);
  CHECK_FALSE(found.contains("getpid"));  // the new thread's and the child's
}

TEST_CASE("After its section a thread works on uncounted, and another section counts again",
          "[realtime_guard]") {
  if (is_skipped()) return;
  const Counts before = counts();
  pid_t process = 0;
  std::thread([&] {
    { const RealtimeSection section; }
    process = ::getpid();
    const RealtimeSection section;
    ::sched_yield();
  }).join();
  CHECK(process == ::getpid());
  CHECK(since(before) == Counts{{"sched_yield", 1}});
}

TEST_CASE("The first call is told with its tick and the module that made it", "[realtime_guard]") {
  if (is_skipped()) return;
  std::thread([] {
    RealtimeSection section;
    for (std::uint64_t tick = 1; tick <= 20; ++tick) {
      section.begin_tick(tick);
      if (tick >= 17) ::getppid();
    }
  }).join();
  const std::vector<RealtimeViolation> violations = realtime_violations();
  const auto found = std::find_if(violations.begin(), violations.end(),
                                  [](const auto& one) { return one.call == "getppid"; });
  REQUIRE(found != violations.end());
  CHECK(found->count == 4);
  CHECK(found->first_tick == 17);
  CHECK(found->first_caller.starts_with("realtime_guard_test+0x"));
}

}  // namespace stillgrid::realtime::realtime_guard_test
