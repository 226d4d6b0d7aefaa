#include "shared/tools/scene_relay/network.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/ethtool.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <string_view>

#include "shared/publication/segment_files.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/scene_relay/interface_filter.hpp"

namespace stillgrid::scene_relay {
namespace {

bool is_private(std::uint32_t address) {
  const auto in = [&](std::uint32_t network, unsigned bits) {
    return (address >> (32 - bits)) == (network >> (32 - bits));
  };
  return in(0x0A000000, 8) || in(0xAC100000, 12) || in(0xC0A80000, 16) || in(0xA9FE0000, 16);
}

/// WireGuard's, or one that a program as OpenVPN holds the other end of; not a modem's, which has
/// no header either.
bool is_tunnel(const std::string& name) {
  const publication::FileDescriptor any(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  ifreq request{};
  name.copy(request.ifr_name, sizeof request.ifr_name - 1);
  if (::ioctl(any.get(), SIOCGIFHWADDR, &request) != 0 ||
      request.ifr_hwaddr.sa_family != ARPHRD_NONE)
    return false;
  ethtool_drvinfo driver{};
  driver.cmd = ETHTOOL_GDRVINFO;
  request.ifr_data = reinterpret_cast<char*>(&driver);
  const std::string_view drivers[] = {"tun", "wireguard"};
  return ::ioctl(any.get(), SIOCETHTOOL, &request) == 0 &&
         std::find(std::begin(drivers), std::end(drivers), driver.driver) != std::end(drivers);
}

void require(dds_return_t code, const std::string& what) {
  if (code < 0) throw NetworkError("DDS: " + what + ": " + dds_strretcode(-code));
}

/// As an attribute's value.
std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += c;
  }
  return result;
}

std::string security_of(const std::filesystem::path& folder) {
  const auto file = [&](const char* name) {
    return "file:" + escaped((std::filesystem::absolute(folder) / name).string());
  };
  return "<Security>"
         "<Authentication>"
         "<Library path=\"dds_security_auth\" initFunction=\"init_authentication\" "
         "finalizeFunction=\"finalize_authentication\"/>"
         "<IdentityCA>" +
         file("identity_ca.pem") +
         "</IdentityCA>"
         "<IdentityCertificate>" +
         file("identity.pem") +
         "</IdentityCertificate>"
         "<PrivateKey>" +
         file("key.pem") +
         "</PrivateKey>"
         "</Authentication>"
         "<AccessControl>"
         "<Library path=\"dds_security_ac\" initFunction=\"init_access_control\" "
         "finalizeFunction=\"finalize_access_control\"/>"
         "<PermissionsCA>" +
         file("permissions_ca.pem") +
         "</PermissionsCA>"
         "<Governance>" +
         file("governance.p7s") +
         "</Governance>"
         "<Permissions>" +
         file("permissions.p7s") +
         "</Permissions>"
         "</AccessControl>"
         "<Cryptographic>"
         "<Library path=\"dds_security_crypto\" initFunction=\"init_crypto\" "
         "finalizeFunction=\"finalize_crypto\"/>"
         "</Cryptographic>"
         "</Security>";
}

using Qos = std::unique_ptr<dds_qos_t, void (*)(dds_qos_t*)>;

/// A reader keeps what several writers sent since the last look, lest a stranger's sample replaces
/// the one that counts.
constexpr std::int32_t kReaderDepth = 16;

/// depth: samples kept.
Qos qos_of(Delivery delivery, std::int32_t depth) {
  Qos qos(dds_create_qos(), dds_delete_qos);
  const bool is_reliable = delivery != Delivery::kBestEffort;
  dds_qset_reliability(qos.get(),
                       is_reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  dds_qset_durability(qos.get(), delivery == Delivery::kLasting ? DDS_DURABILITY_TRANSIENT_LOCAL
                                                                : DDS_DURABILITY_VOLATILE);
  return qos;
}

}  // namespace

Interface interface_named(const std::string& name) {
  ifaddrs* all = nullptr;
  if (::getifaddrs(&all) != 0) throw NetworkError("network interfaces cannot be listed");
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> owner(all, ::freeifaddrs);
  std::string known;
  for (const ifaddrs* at = all; at != nullptr; at = at->ifa_next) {
    if (at->ifa_addr == nullptr || at->ifa_addr->sa_family != AF_INET) continue;
    known += (known.empty() ? "" : ", ") + std::string(at->ifa_name);
    if (name != at->ifa_name) continue;
    const auto& address = *reinterpret_cast<const sockaddr_in*>(at->ifa_addr);
    char text[INET_ADDRSTRLEN] = {};
    ::inet_ntop(AF_INET, &address.sin_addr, text, sizeof text);
    return {.address = text,
            .is_loopback = (at->ifa_flags & IFF_LOOPBACK) != 0,
            .is_tunnel = is_tunnel(name),
            .is_private = is_private(ntohl(address.sin_addr.s_addr))};
  }
  throw NetworkError("--interface '" + name + "': expected one with an IPv4 address: " + known);
}

void require_said_who_joins(const NetworkOptions& options, const Interface& interface) {
  if (!options.security.empty() || interface.is_loopback || interface.is_tunnel) return;
  const std::string where = "--interface " + options.interface + " (" + interface.address + "): ";
  if (!interface.is_private)
    throw NetworkError(where +
                       "expected a tunnel, or --security FOLDER: anyone may send to this address");
  if (!options.is_open)
    throw NetworkError(where +
                       "who may join? expected --security FOLDER, a tunnel, or --open if whoever "
                       "is in this network may move the tool and be felt");
}

void require_security_files(const std::filesystem::path& folder) {
  for (const char* name : {"identity_ca.pem", "identity.pem", "key.pem", "permissions_ca.pem",
                           "governance.p7s", "permissions.p7s"})
    if (!std::filesystem::is_regular_file(folder / name))
      throw NetworkError("--security " + folder.string() + ": expected a file " + name +
                         " (docs/network.md)");
}

std::string configuration_of(const NetworkOptions& options, const Interface& interface) {
  const bool asks_all = options.peers.empty() && !interface.is_loopback;
  std::string peers;
  for (const std::string& peer : options.peers)
    peers += "<Peer address=\"" + escaped(peer) + "\"/>";
  if (interface.is_loopback) peers += "<Peer address=\"localhost\"/>";
  // A message is a packet, so that what is lost is one; answers to a gap come at once, not after
  // the tenth of a second that suits a full network of many.
  return "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"" +
         escaped(interface.is_loopback ? "lo" : options.interface) +
         "\"/></Interfaces><AllowMulticast>" + (asks_all ? "spdp" : "false") +
         "</AllowMulticast><MaxMessageSize>1456B</MaxMessageSize><FragmentSize>1344B</FragmentSize>"
         "</General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
         "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex><SPDPInterval>250ms</SPDPInterval>"
         "<Peers>" +
         peers +
         "</Peers></Discovery>"
         "<Internal><Watermarks><WhcHigh>512MB</WhcHigh></Watermarks><NackDelay>0s</NackDelay>"
         "<WriterLingerDuration>0s</WriterLingerDuration>"
         "<MaxQueuedRexmitBytes>16MB</MaxQueuedRexmitBytes>"
         "<MaxQueuedRexmitMessages>20000</MaxQueuedRexmitMessages>"
         "<HeartbeatInterval max=\"200ms\" min=\"2ms\" minsched=\"5ms\">20ms</HeartbeatInterval>"
         "<SocketReceiveBufferSize min=\"default\" max=\"8MB\"/></Internal>" +
         (options.security.empty() ? std::string() : security_of(options.security)) +
         "</Domain></CycloneDDS>";
}

Participant::Participant(const NetworkOptions& options) {
  const Interface interface = interface_named(options.interface.empty() ? "lo" : options.interface);
  require_said_who_joins(options, interface);
  if (!options.security.empty()) require_security_files(options.security);
  domain_ = dds_create_domain(options.domain, configuration_of(options, interface).c_str());
  require(domain_, "domain " + std::to_string(options.domain));
  participant_ = dds_create_participant(options.domain, nullptr, nullptr);
  if (participant_ < 0) {
    dds_delete(domain_);
    const std::string what =
        options.security.empty() ? "participant" : "--security " + options.security.string();
    throw NetworkError("DDS: " + what + ": " +
                       (log_.last().empty() ? dds_strretcode(-participant_) : log_.last()));
  }
  log_.tell();
  try {
    hear_only(interface.is_loopback ? "lo" : options.interface);
  } catch (...) {
    dds_delete(domain_);
    throw;
  }
  waitset_ = dds_create_waitset(participant_);
  require(waitset_, "waitset");
}

Participant::~Participant() {
  dds_delete(participant_);
  dds_delete(domain_);
}

dds_entity_t Participant::writer(const dds_topic_descriptor_t& type, const std::string& topic,
                                 Delivery delivery) const {
  const dds_entity_t entity =
      dds_create_topic(participant_, &type, topic.c_str(), nullptr, nullptr);
  require(entity, "topic " + topic);
  const dds_entity_t writer =
      dds_create_writer(participant_, entity, qos_of(delivery, 1).get(), nullptr);
  require(writer, "writer of " + topic);
  return writer;
}

dds_entity_t Participant::reader(const dds_topic_descriptor_t& type, const std::string& topic,
                                 Delivery delivery, bool wakes) const {
  const dds_entity_t entity =
      dds_create_topic(participant_, &type, topic.c_str(), nullptr, nullptr);
  require(entity, "topic " + topic);
  const dds_entity_t reader =
      dds_create_reader(participant_, entity, qos_of(delivery, kReaderDepth).get(), nullptr);
  require(reader, "reader of " + topic);
  if (wakes) {
    require(dds_set_status_mask(reader, DDS_DATA_AVAILABLE_STATUS), "status of " + topic);
    require(dds_waitset_attach(waitset_, reader, reader), "waitset");
  }
  return reader;
}

void Participant::wait(std::uint64_t until_ns) const noexcept {
  const std::uint64_t now_ns = realtime::monotonic_ns();
  if (until_ns <= now_ns) return;
  dds_waitset_wait(waitset_, nullptr, 0, static_cast<dds_duration_t>(until_ns - now_ns));
}

}  // namespace stillgrid::scene_relay
