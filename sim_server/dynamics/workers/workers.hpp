#pragma once

#include <cstddef>
#include <memory>

#include "shared/dynamics/work_sharing.hpp"

namespace stillgrid::dynamics {

/// Shares the work of a large scene by threads of oneTBB.
class Workers : public WorkSharing {
 public:
  /// The caller counts among the threads. Where the system refuses some there are fewer. Pre: at
  /// least 1.
  explicit Workers(int threads = 1);
  ~Workers() override;

  [[nodiscard]] int threads() const noexcept { return threads_; }

 private:
  void share(std::size_t chunks, void (*one)(const void*, std::size_t),
             const void* work) const override;

  struct Arena;
  int threads_;
  std::unique_ptr<Arena> arena_;
};

}  // namespace stillgrid::dynamics
