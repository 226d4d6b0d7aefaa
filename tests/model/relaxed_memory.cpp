#include "tests/model/relaxed_memory.hpp"

#include <algorithm>
#include <cassert>

namespace stillgrid::model {
namespace {

void join(View& view, const View& other) {
  for (std::size_t i = 0; i < view.size(); ++i) view[i] = std::max(view[i], other[i]);
}

bool is_release(std::memory_order order) {
  return order == std::memory_order_release || order == std::memory_order_seq_cst;
}

bool is_acquire(std::memory_order order) {
  return order == std::memory_order_acquire || order == std::memory_order_seq_cst;
}

}  // namespace

RelaxedMemory::RelaxedMemory(std::size_t locations) {
  assert(locations <= kMaxLocations);
  for (std::size_t i = 0; i < locations; ++i) messages_[i].push_back({});
}

void RelaxedMemory::start_writer() noexcept {
  ++writer_;
  released_ = {};
}

void RelaxedMemory::store(std::size_t location, std::uint64_t value, std::memory_order order) {
  assert(messages_[location].size() < UINT8_MAX);
  ++newest_[location];
  Message message{value, writer_, is_release(order) ? newest_ : released_};
  message.view[location] = newest_[location];
  messages_[location].push_back(message);
}

std::uint64_t Reader::load(const RelaxedMemory& memory, std::size_t location, std::size_t index,
                           std::memory_order order) noexcept {
  assert(index >= current[location] && index <= memory.newest(location));
  const Message& message = memory.message(location, index);
  current[location] = static_cast<std::uint8_t>(index);
  join(pending, message.view);
  if (is_acquire(order)) join(current, message.view);
  return message.value;
}

std::size_t Choices::choose(std::size_t count) {
  if (repeated_ == made_.size()) made_.push_back({0, count});
  assert(made_[repeated_].count == count);
  return made_[repeated_++].chosen;
}

bool Choices::next() {
  repeated_ = 0;
  while (!made_.empty() && made_.back().chosen + 1 == made_.back().count) made_.pop_back();
  if (made_.empty()) return false;
  ++made_.back().chosen;
  return true;
}

}  // namespace stillgrid::model
