#include "sim_server/dynamics/workers/workers.hpp"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace stillgrid::dynamics {

struct Workers::Arena {
  explicit Arena(int threads)
      : as_asked(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)),
        arena(threads) {}

  tbb::global_control as_asked;  // also where there are fewer processors
  tbb::task_arena arena;
};

Workers::Workers(int threads) : threads_(threads) {
  if (threads > 1) arena_ = std::make_unique<Arena>(threads);
}

Workers::~Workers() = default;

const Workers& Workers::alone() {
  static const Workers alone;
  return alone;
}

void Workers::share(std::size_t chunks, void (*one)(const void*, std::size_t),
                    const void* work) const {
  arena_->arena.execute(
      [&] { tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t i) { one(work, i); }); });
}

}  // namespace stillgrid::dynamics
