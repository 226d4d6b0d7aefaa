#include "shared/dynamics/byte_block.hpp"

namespace stillgrid::dynamics {

// Not inline: g++ 12 then warns of an overflow that cannot be, where the size is a constant.
void BlockWriter::append(std::span<const std::byte> bytes) {
  if (bytes.empty()) return;
  const std::size_t size = block_.size();
  block_.resize(size + bytes.size());
  std::memcpy(block_.data() + size, bytes.data(), bytes.size());
}

}  // namespace stillgrid::dynamics
