#include "tests/network/network_side.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <linux/if_tun.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>

#include "tests/network/side_holder.hpp"

namespace stillgrid::network {
namespace {

constexpr const char* kInterface = "link";
constexpr std::uint32_t kQueueLength = 20'000;  // packets: a snapshot of some MB at once

int granted(int result, const std::string& what) {
  if (result < 0) throw NotGranted(what + ": " + std::strerror(errno));
  return result;
}

void write_kernel_file(const std::string& file, const std::string& text) {
  const int opened = granted(::open(file.c_str(), O_WRONLY | O_CLOEXEC), file);
  const bool is_written =
      ::write(opened, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const int error = errno;
  ::close(opened);
  if (!is_written) throw NotGranted(file + ": " + std::strerror(error));
}

ifreq request_of(const char* interface) {
  ifreq request{};
  std::strncpy(request.ifr_name, interface, IFNAMSIZ - 1);
  return request;
}

void configure(int socket, unsigned long call, ifreq request, const char* what) {
  granted(::ioctl(socket, call, &request), std::string(request.ifr_name) + ": " + what);
}

void set_address(int socket, unsigned long call, const std::string& address) {
  ifreq request = request_of(kInterface);
  sockaddr_in internet{};
  internet.sin_family = AF_INET;
  if (::inet_pton(AF_INET, address.c_str(), &internet.sin_addr) != 1)
    throw NotGranted(address + ": no address");
  std::memcpy(&request.ifr_addr, &internet, sizeof internet);
  configure(socket, call, request, address.c_str());
}

void set_up(int socket, const char* interface, int flags) {
  ifreq request = request_of(interface);
  request.ifr_flags = static_cast<short>(flags);
  configure(socket, SIOCSIFFLAGS, request, "up");
}

/// By netlink: the older call is root's alone, in no user namespace.
void set_queue_length() {
  struct {
    nlmsghdr header;
    ifinfomsg interface;
    rtattr attribute;
    std::uint32_t length;
  } request{};
  request.header.nlmsg_len = sizeof request;
  request.header.nlmsg_type = RTM_NEWLINK;
  request.header.nlmsg_flags = NLM_F_REQUEST | NLM_F_ACK;
  request.interface.ifi_index = static_cast<int>(::if_nametoindex(kInterface));
  request.attribute = {RTA_LENGTH(sizeof request.length), IFLA_TXQLEN};
  request.length = kQueueLength;
  struct {
    nlmsghdr header;
    nlmsgerr error;
    char rest[256];
  } reply{};
  const int socket =
      granted(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE), "netlink");
  const bool is_asked = ::send(socket, &request, sizeof request, 0) == sizeof request &&
                        ::recv(socket, &reply, sizeof reply, 0) >=
                            static_cast<ssize_t>(sizeof(nlmsghdr) + sizeof(int));
  ::close(socket);
  if (is_asked) errno = -reply.error.error;
  granted(is_asked && reply.error.error == 0 ? 0 : -1, "link: a longer queue");
}

int make_tun() {
  const int tun = granted(::open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC), "/dev/net/tun");
  ifreq request = request_of(kInterface);
  request.ifr_flags = IFF_TUN | IFF_NO_PI;
  granted(::ioctl(tun, TUNSETIFF, &request), "a TUN interface");
  return tun;
}

int make_interface(const std::string& address) {
  const int tun = make_tun();
  const int socket = granted(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0), "a socket");
  set_up(socket, "lo", IFF_UP);
  try {  // its own messages would be the link's first
    write_kernel_file("/proc/sys/net/ipv6/conf/link/disable_ipv6", "1");
  } catch (const NotGranted&) {  // a machine without IPv6, or that lets nobody write there: the
                                 // pump drops them
  }
  set_address(socket, SIOCSIFADDR, address);
  set_address(socket, SIOCSIFNETMASK, "255.255.255.0");
  set_queue_length();
  set_up(socket, kInterface, IFF_UP | IFF_MULTICAST);
  ::close(socket);
  return tun;
}

}  // namespace

Lifeline make_lifeline() {
  int ends[2];
  granted(::pipe2(ends, O_CLOEXEC), "a pipe");
  return {ends[0], ends[1]};
}

bool enter_own_rights() {
  if (::unshare(CLONE_NEWNET) == 0) return false;
  const std::string user = std::to_string(::geteuid()), group = std::to_string(::getegid());
  granted(::unshare(CLONE_NEWUSER), "network namespaces, and user namespaces to make them in");
  write_kernel_file("/proc/self/setgroups", "deny");
  write_kernel_file("/proc/self/uid_map", "0 " + user + " 1");
  write_kernel_file("/proc/self/gid_map", "0 " + group + " 1");
  return true;
}

NetworkSide make_side(const std::string& address, double clock_offset_s, const Lifeline& lifeline) {
  leave_sides();
  NetworkSide side;
  side.tun = make_interface(address);
  side.has_own_clock = clock_offset_s != 0.0;
  side.holder = start_holder(clock_offset_s, lifeline);
  return side;
}

void leave_sides() {
  granted(::unshare(CLONE_NEWNET), "a network namespace");
}

}  // namespace stillgrid::network
