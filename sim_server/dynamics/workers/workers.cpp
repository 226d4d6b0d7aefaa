#include "sim_server/dynamics/workers/workers.hpp"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <new>
#include <system_error>
#include <thread>
#include <vector>

#include "shared/realtime/flush_denormals.hpp"

namespace stillgrid::dynamics {
namespace {

/// oneTBB ends the process where the system refuses a thread: it is asked for no more than there
/// are, and for half of them where some were refused, for its own take memory too. At most `most`.
///
/// One after another: a heap takes as much of what may be had as several stacks, and is not made
/// for a thread that comes when stacks have taken all. What the threads of oneTBB, which begin at
/// their leisure, would take in heaps is then counted too.
int threads_to_be_had(int most) {
  std::atomic<bool> all_here = false;
  std::vector<std::thread> others;
  others.reserve(static_cast<std::size_t>(most));
  std::atomic<int> had = 1;
  std::atomic<int> begun = 0;
  try {
    while (static_cast<int>(others.size()) + 1 < most) {
      others.emplace_back([&] {
        const std::unique_ptr<char[]> own(new (std::nothrow) char[1024]);  // with its heap
        if (own) ++had;
        ++begun;
        begun.notify_one();
        all_here.wait(false);
      });
      begun.wait(static_cast<int>(others.size()) - 1);
    }
  } catch (const std::system_error&) {  // as many as there are
  }
  all_here = true;
  all_here.notify_all();
  for (std::thread& other : others) other.join();
  return had == most ? most : (had + 1) / 2;
}

}  // namespace

struct Workers::Arena {
  explicit Arena(int threads)
      : as_asked(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)),
        arena(threads) {
    arena.execute([&] { make_all(threads); });
  }

  /// At once, while they are known to be had: each waits for all others, within reason.
  static void make_all(int threads) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(1);
    std::atomic<int> here = 0;
    tbb::task_group group;
    for (int i = 0; i < threads; ++i)
      group.run([&] {
        ++here;
        while (here < threads && std::chrono::steady_clock::now() < end) std::this_thread::yield();
      });
    group.wait();
  }

  realtime::FlushDenormals flush;  // threads take it from the one that makes the arena
  tbb::global_control as_asked;    // also where there are fewer processors
  tbb::task_arena arena;
};

Workers::Workers(int threads) : threads_(threads_to_be_had(threads)) {
  if (threads_ > 1) arena_ = std::make_unique<Arena>(threads_);
}

Workers::~Workers() = default;

void Workers::share(std::size_t chunks, void (*one)(const void*, std::size_t),
                    const void* work) const {
  if (threads_ == 1 || chunks < 2) {
    for (std::size_t i = 0; i < chunks; ++i) one(work, i);
    return;
  }
  arena_->arena.execute(
      [&] { tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t i) { one(work, i); }); });
}

}  // namespace stillgrid::dynamics
