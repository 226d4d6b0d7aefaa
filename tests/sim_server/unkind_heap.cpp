#include "tests/sim_server/unkind_heap.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>

namespace {

std::size_t heap_offset_B = 0;

/// What malloc gave stands in the word before a block.
void* allocate(std::size_t size, std::size_t alignment) {
  const std::size_t whole = std::max<std::size_t>(alignment, 64);
  const std::size_t ahead = alignment < 64 ? 64 + heap_offset_B / alignment * alignment : alignment;
  void* memory = nullptr;
  if (posix_memalign(&memory, 2 * whole, ahead + size) != 0) throw std::bad_alloc();
  auto* const block = static_cast<std::byte*>(memory) + ahead;
  std::memcpy(block - sizeof(memory), &memory, sizeof(memory));
  return block;
}

void release(void* block) noexcept {
  if (block == nullptr) return;
  void* memory = nullptr;
  std::memcpy(&memory, static_cast<std::byte*>(block) - sizeof(memory), sizeof(memory));
  std::free(memory);
}

}  // namespace

void* operator new(std::size_t size) {
  return allocate(size, alignof(std::max_align_t));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
  try {
    return allocate(size, alignof(std::max_align_t));
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void operator delete(void* block) noexcept {
  release(block);
}
void operator delete(void* block, std::size_t /*size*/) noexcept {
  release(block);
}
void operator delete(void* block, std::align_val_t /*alignment*/) noexcept {
  release(block);
}
void operator delete(void* block, std::size_t /*size*/, std::align_val_t /*alignment*/) noexcept {
  release(block);
}

namespace stillgrid::sim_server {

UnkindHeap::UnkindHeap(std::size_t offset_B) noexcept {
  heap_offset_B = offset_B;
}
UnkindHeap::~UnkindHeap() {
  heap_offset_B = 0;
}

}  // namespace stillgrid::sim_server
