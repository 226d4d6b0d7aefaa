#include "shared/tools/scene_relay/interface_filter.hpp"

#include <linux/filter.h>
#include <net/if.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>

#include "shared/tools/scene_relay/network.hpp"

namespace stillgrid::scene_relay {
namespace {

int option_of(int fd, int option) {
  int value = -1;
  socklen_t bytes = sizeof value;
  return ::getsockopt(fd, SOL_SOCKET, option, &value, &bytes) == 0 ? value : -1;
}

bool is_udp(int fd) {
  const int family = option_of(fd, SO_DOMAIN);
  return (family == AF_INET || family == AF_INET6) && option_of(fd, SO_TYPE) == SOCK_DGRAM;
}

}  // namespace

void hear_only(const std::string& interface) {
  const unsigned index = ::if_nametoindex(interface.c_str());
  const unsigned loopback = ::if_nametoindex("lo");
  if (index == 0) throw NetworkError("--interface '" + interface + "' is gone");
  // Of classic BPF: the number of the interface that a packet came by.
  std::array<sock_filter, 5> code{{
      {BPF_LD | BPF_W | BPF_ABS, 0, 0, static_cast<std::uint32_t>(SKF_AD_OFF + SKF_AD_IFINDEX)},
      {BPF_JMP | BPF_JEQ | BPF_K, 2, 0, index},
      {BPF_JMP | BPF_JEQ | BPF_K, 1, 0, loopback},
      {BPF_RET | BPF_K, 0, 0, 0},
      {BPF_RET | BPF_K, 0, 0, UINT32_MAX},
  }};
  const sock_fprog program{static_cast<unsigned short>(code.size()), code.data()};
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int fd = std::stoi(entry.path().filename().string());
    if (!is_udp(fd)) continue;
    if (::setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) != 0)
      throw NetworkError("--interface '" + interface +
                         "': others cannot be shut out: " + std::strerror(errno));
  }
}

}  // namespace stillgrid::scene_relay
