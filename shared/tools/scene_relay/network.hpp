#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "shared/tools/scene_relay/middleware_log.hpp"

namespace stillgrid::scene_relay {

/// What Cyclone DDS refused, one line.
class NetworkError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Where a relay talks, and who may join.
struct NetworkOptions {
  std::string interface;           // empty: loopback
  std::vector<std::string> peers;  // addresses to ask; empty: whoever answers a multicast
  std::uint32_t domain = 0;
  std::filesystem::path security;  // folder of DDS Security; empty: none
  bool is_open = false;            // whoever is in the private network may join
};

/// What an interface is, as the kernel tells.
struct Interface {
  std::string address;  // the first of IPv4
  bool is_loopback = false;
  bool is_tunnel = false;   // WireGuard's, or a program's as OpenVPN
  bool is_private = false;  // RFC 1918, RFC 3927
};
/// Throws NetworkError where there is none of that name, or it has no address.
[[nodiscard]] Interface interface_named(const std::string& name);

/// Throws NetworkError unless it is said who may join: loopback and tunnels say it themselves;
/// elsewhere DDS Security does, or on a private network the word that whoever is there may.
void require_said_who_joins(const NetworkOptions& options, const Interface& interface);

/// Throws NetworkError naming the first file of DDS Security that the folder lacks.
void require_security_files(const std::filesystem::path& folder);

/// The configuration of Cyclone DDS by which it keeps to that interface (XML).
[[nodiscard]] std::string configuration_of(const NetworkOptions& options,
                                           const Interface& interface);

/// How the samples of a topic come.
enum class Delivery {
  kBestEffort,  // the newest counts; what is lost is not sent again
  kNewest,      // reliable; what a newer one has replaced is not sent again
  kLasting,     // the same, also for those who join later
};

/// A process's part in a DDS domain. Thread: one.
class Participant {
 public:
  /// Throws NetworkError.
  explicit Participant(const NetworkOptions& options);
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;
  Participant(Participant&&) = delete;
  Participant& operator=(Participant&&) = delete;

  [[nodiscard]] dds_entity_t entity() const noexcept { return participant_; }
  /// Throw NetworkError.
  [[nodiscard]] dds_entity_t writer(const dds_topic_descriptor_t& type, const std::string& topic,
                                    Delivery delivery) const;
  /// Wakes wait() when something comes, if `wakes`.
  [[nodiscard]] dds_entity_t reader(const dds_topic_descriptor_t& type, const std::string& topic,
                                    Delivery delivery, bool wakes = true) const;

  /// Until something came or until_ns of the monotonic clock.
  void wait(std::uint64_t until_ns) const noexcept;

 private:
  MiddlewareLog log_;
  dds_entity_t domain_ = 0, participant_ = 0, waitset_ = 0;
};

/// Takes what has come: use(message) of each.
template <class Message, class Use>
void take_all(dds_entity_t reader, const Use& use) {
  constexpr std::size_t kAtOnce = 8;
  while (true) {
    void* samples[kAtOnce] = {};
    dds_sample_info_t infos[kAtOnce];
    const dds_return_t count = dds_take(reader, samples, infos, kAtOnce, kAtOnce);
    if (count <= 0) return;
    for (dds_return_t i = 0; i < count; ++i)
      if (infos[i].valid_data) use(*static_cast<const Message*>(samples[i]));
    dds_return_loan(reader, samples, count);
    if (static_cast<std::size_t>(count) < kAtOnce) return;
  }
}

}  // namespace stillgrid::scene_relay
