#pragma once

#include <cstddef>

namespace stillgrid::sim_server {

/// While it lives, what operator new hands out is aligned to what was asked for and no more: it
/// begins offset_B bytes (0, 16, 32 or 48) beyond a multiple of 64, or, asked for more than 16, as
/// much of these as that allows. A block ends where its memory does, so that a sanitizer sees what
/// is read beyond it. For programs of one thread that link unkind_heap.cpp.
class UnkindHeap {
 public:
  explicit UnkindHeap(std::size_t offset_B) noexcept;
  ~UnkindHeap();
  UnkindHeap(const UnkindHeap&) = delete;
  UnkindHeap& operator=(const UnkindHeap&) = delete;
};

}  // namespace stillgrid::sim_server
