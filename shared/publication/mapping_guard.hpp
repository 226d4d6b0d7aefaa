#pragma once

#include <cstddef>
#include <span>

namespace stillgrid::publication {

/// Lets this process outlive a shared-memory object that somebody shrinks while it is mapped:
/// touching what is gone raises SIGBUS, and shared memory cannot be sealed against it.
///
/// While a guard stands for a mapping, a handler of SIGBUS replaces the whole of it by zeros in
/// private memory and notes the loss; the access that failed goes on there. Other faults go where
/// they went before. Thread: any.
class MappingGuard {
 public:
  enum class Access { kRead, kWrite };

  /// Pre: the bytes are a mapping that outlives the guard, page-aligned. Throws SegmentError when
  /// kMax guards stand.
  MappingGuard(std::span<const std::byte> mapping, Access access);
  ~MappingGuard();
  MappingGuard(MappingGuard&& other) noexcept;
  MappingGuard& operator=(MappingGuard&&) = delete;
  MappingGuard(const MappingGuard&) = delete;
  MappingGuard& operator=(const MappingGuard&) = delete;

  /// Whether the object was lost: what is read there since is zero. Realtime: yes.
  [[nodiscard]] bool is_lost() const noexcept;

  /// Guards at one time in a process.
  static constexpr std::size_t kMax = 64;

 private:
  std::size_t entry_;
};

}  // namespace stillgrid::publication
