#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "proto/segment_header.hpp"

namespace stillgrid::fuzz {

/// A shared-memory object under a session of this process alone, every byte of which a hostile
/// writer chose. All its pages are there. Locked, so that its writer counts as alive.
class HostileObject {
 public:
  HostileObject(proto::SegmentKind kind, std::span<const std::byte> bytes);
  ~HostileObject();
  HostileObject(const HostileObject&) = delete;
  HostileObject& operator=(const HostileObject&) = delete;

  [[nodiscard]] static std::string session();

  /// Writable, as its writer has them. Not after shrink().
  [[nodiscard]] std::span<std::byte> bytes() const noexcept { return bytes_; }

  /// Takes the name away, so that not even a crash leaves it behind.
  void remove_name() noexcept;

  /// Takes the bytes behind `size_bytes` away from under whoever has mapped them.
  void shrink(std::size_t size_bytes) const noexcept;

 private:
  std::string path_;
  int fd_;
  std::span<std::byte> bytes_;
};

}  // namespace stillgrid::fuzz
