#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <vector>

namespace stillgrid::dynamics {

static_assert(std::endian::native == std::endian::little);  // the byte order of blocks

/// Appends numbers to a block of bytes. Thread: one. Realtime: yes, where the block has had the
/// size before.
class BlockWriter {
 public:
  /// Clears the block. Pre: it outlives the writer.
  explicit BlockWriter(std::vector<std::byte>& block) : block_(block) { block_.clear(); }

  template <class T>
  requires std::is_arithmetic_v<T>
  void add(T number) { append(std::as_bytes(std::span(&number, 1))); }
  /// Adds the count, then the bytes of the values in memory.
  template <class T>
  void add(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    add<std::uint64_t>(values.size());
    append(std::as_bytes(std::span(values)));
  }

 private:
  void append(std::span<const std::byte> bytes);

  std::vector<std::byte>& block_;
};

/// Reads the numbers of a BlockWriter. The bytes may be hostile: a read throws
/// std::invalid_argument where the block ends too early, before it allocates. Thread: one.
class BlockReader {
 public:
  /// Pre: the block outlives the reader.
  explicit BlockReader(std::span<const std::byte> block) : left_(block) {}

  template <class T>
  requires std::is_arithmetic_v<T> T number() {
    T value{};
    copy(&value, 1);
    return value;
  }
  /// Returns a count of items that take item_size bytes each. The block is long enough for them.
  std::uint64_t count(std::size_t item_size) {
    const auto items = number<std::uint64_t>();
    if (items > left_.size() / item_size) throw std::invalid_argument("the block ends too early");
    return items;
  }
  template <class T>
  void read(std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    values.resize(count(sizeof(T)));
    copy(values.data(), values.size());
  }
  [[nodiscard]] bool is_at_end() const { return left_.empty(); }

 private:
  template <class T>
  void copy(T* values, std::size_t count) {
    const std::size_t size = count * sizeof(T);
    if (size > left_.size()) throw std::invalid_argument("the block ends too early");
    if (size > 0) std::memcpy(static_cast<void*>(values), left_.data(), size);
    left_ = left_.subspan(size);
  }
  std::span<const std::byte> left_;
};

}  // namespace stillgrid::dynamics
