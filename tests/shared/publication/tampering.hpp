#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace stillgrid::publication {

/// Writable bytes of a shared-memory object, as a faulty or hostile writer has them.
class Tampering {
 public:
  explicit Tampering(const std::string& path);
  ~Tampering();
  Tampering(const Tampering&) = delete;
  Tampering& operator=(const Tampering&) = delete;

  [[nodiscard]] std::span<std::byte> bytes() const noexcept { return bytes_; }
  template <class T>
  [[nodiscard]] T& at(std::size_t offset_bytes) const {
    return *reinterpret_cast<T*>(bytes_.data() + offset_bytes);
  }

 private:
  std::span<std::byte> bytes_;
};

}  // namespace stillgrid::publication
