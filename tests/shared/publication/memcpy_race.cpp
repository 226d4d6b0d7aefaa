// What the thread sanitizer must find: the double buffer with a payload of plain copies. That it
// finds this shows that it would have found a plain access in the real one.
#include <array>
#include <atomic>
#include <cstdio>
#include <cstring>
#include <thread>

#include "shared/double_buffer/double_buffer.hpp"

namespace stillgrid::publication {
namespace {

struct PlainPayload : double_buffer::HardwareAtomics {
  static void store(std::uint64_t& word, std::uint64_t value, std::memory_order order) noexcept {
    if (order == std::memory_order_relaxed)  // W3 alone
      std::memcpy(&word, &value, sizeof value);
    else
      double_buffer::HardwareAtomics::store(word, value, order);
  }
};

using Words = std::array<std::uint64_t, 64>;

struct Memory {
  std::uint64_t latest = 0;
  std::array<std::uint64_t, 2> sequence{};
  std::array<Words, 2> payload{};
};

}  // namespace

namespace {

int program_main() {
  Memory memory;
  const double_buffer::DoubleBuffer buffer{&memory.latest,
                                           {&memory.sequence[0], &memory.sequence[1]},
                                           {memory.payload[0].data(), memory.payload[1].data()}};
  std::atomic<bool> stop = false;
  std::thread writer([&] {
    Words words{};
    for (std::uint64_t n = 1; !stop.load(std::memory_order_relaxed); ++n) {
      words.fill(n);
      double_buffer::publish<PlainPayload>(buffer, n, {{0, words}});
    }
  });
  Words copy{};
  std::uint64_t sum = 0;  // printed, or the compiler would leave the copy out
  while (double_buffer::HardwareAtomics::load(memory.latest, std::memory_order_relaxed) < 100000)
    static_cast<void>(double_buffer::read_latest(buffer, [&](const std::uint64_t* payload) {
      std::memcpy(copy.data(), payload, sizeof copy);
      for (const std::uint64_t word : copy) sum += word;
    }));
  stop = true;
  writer.join();
  std::printf("%llu\n", static_cast<unsigned long long>(sum));
  return 0;
}

}  // namespace
}  // namespace stillgrid::publication

int main() {
  return stillgrid::publication::program_main();
}
