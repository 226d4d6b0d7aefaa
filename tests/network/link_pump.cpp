#include "tests/network/link_pump.hpp"

#include <netinet/in.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <span>

#include "shared/realtime/periodic_timer.hpp"

namespace stillgrid::network {
namespace {

constexpr int kAtOnce = 64;  // packets of one side before the other has its turn
constexpr std::uint64_t kLongestSleep_ns = 100'000'000;
constexpr std::uint64_t kSecond_ns = 1'000'000'000;

/// IPv4 but IGMP, which would speak to a router.
bool is_carried(std::span<const std::uint8_t> packet) {
  return packet.size() >= 20 && packet[0] >> 4 == 4 && packet[9] != IPPROTO_IGMP;
}

}  // namespace

bool LinkPump::carry_until_readable(int file) {
  const bool is_readable = sleep(file);
  for (const std::size_t side : {0U, 1U}) {
    take(side);
    deliver(side);
  }
  return is_readable;
}

void LinkPump::take(std::size_t from) {
  std::array<std::uint8_t, 2048> packet;
  for (int i = 0; i < kAtOnce; ++i) {
    const ssize_t size = ::read(tuns_[from], packet.data(), packet.size());
    if (size <= 0) return;
    const std::span<const std::uint8_t> bytes(packet.data(), static_cast<std::size_t>(size));
    if (is_carried(bytes)) directions_[from].send(bytes, realtime::monotonic_ns());
  }
}

void LinkPump::deliver(std::size_t from) {
  const int to = tuns_[1 - from];
  directions_[from].deliver_due(
      realtime::monotonic_ns(), [to](std::span<const std::uint8_t> packet) {
        return ::write(to, packet.data(), packet.size()) == static_cast<ssize_t>(packet.size());
      });
}

/// Until a packet or the file is to be read, or a packet is due. Returns whether the file is.
bool LinkPump::sleep(int file) {
  const std::uint64_t now_ns = realtime::monotonic_ns();
  std::uint64_t until_ns = now_ns + kLongestSleep_ns;
  for (const LinkDirection& direction : directions_)
    until_ns = std::min(until_ns, direction.next_due_ns().value_or(until_ns));
  const std::uint64_t left_ns = until_ns > now_ns ? until_ns - now_ns : 0;
  const timespec timeout{static_cast<time_t>(left_ns / kSecond_ns),
                         static_cast<long>(left_ns % kSecond_ns)};
  std::array<pollfd, 3> files = {{{tuns_[0], POLLIN, 0}, {tuns_[1], POLLIN, 0}, {file, POLLIN, 0}}};
  return ::ppoll(files.data(), files.size(), &timeout, nullptr) > 0 && files[2].revents != 0;
}

}  // namespace stillgrid::network
