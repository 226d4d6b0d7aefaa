#include "shared/tools/scene_relay/network.hpp"

#include <algorithm>
#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <catch2/catch.hpp>
#include <random>
#include <sstream>

namespace stillgrid::scene_relay::network_test {
namespace {

boost::property_tree::ptree parsed(const std::string& xml) {
  std::istringstream stream(xml);
  boost::property_tree::ptree tree;
  boost::property_tree::read_xml(stream, tree);  // throws where it is not well-formed
  return tree.get_child("CycloneDDS.Domain");
}

std::vector<std::string> peers_of(const boost::property_tree::ptree& domain) {
  std::vector<std::string> peers;
  for (const auto& [name, peer] : domain.get_child("Discovery.Peers"))
    if (name == "Peer") peers.push_back(peer.get<std::string>("<xmlattr>.address"));
  return peers;
}

std::string interface_of(const boost::property_tree::ptree& domain) {
  return domain.get<std::string>("General.Interfaces.NetworkInterface.<xmlattr>.name");
}

/// Whatever a shell lets stand in an argument.
std::string hostile_text(std::mt19937& random) {
  constexpr std::string_view kOdd = "\"'<>&;/ ]!-.:a9";
  std::string text = "x";
  for (std::size_t length = random() % 17; length > 0; --length)
    text += kOdd[random() % kOdd.size()];
  return text + "y";
}

}  // namespace

TEST_CASE("The loopback is known by its name, and others are named where one is not there",
          "[network]") {
  const Interface loopback = interface_named("lo");
  CHECK(loopback.address == "127.0.0.1");
  CHECK(loopback.is_loopback);
  CHECK_FALSE(loopback.is_tunnel);
  CHECK_FALSE(loopback.is_private);
  for (const std::string name : {"nosuch0", "", "l", "lo ", "LO"}) {
    std::string line;
    try {
      static_cast<void>(interface_named(name));
    } catch (const NetworkError& error) {
      line = error.what();
    }
    CHECK(line.find("'" + name + "'") != std::string::npos);
    CHECK(line.find("IPv4 address: ") != std::string::npos);
    CHECK(line.find("lo", line.find("address: ")) != std::string::npos);
    CHECK(line.find('\n') == std::string::npos);
  }
}

TEST_CASE(
    "Who may join is said by the loopback, a tunnel or security, in a private network by a "
    "word, elsewhere by none",
    "[network]") {
  for (const bool is_loopback : {false, true})
    for (const bool is_tunnel : {false, true})
      for (const bool is_private : {false, true})
        for (const bool is_secured : {false, true})
          for (const bool is_open : {false, true}) {
            NetworkOptions options;
            options.interface = "eth7";
            options.is_open = is_open;
            if (is_secured) options.security = "keys";
            const Interface interface { "198.51.100.3", is_loopback, is_tunnel, is_private };
            std::string line;
            try {
              require_said_who_joins(options, interface);
            } catch (const NetworkError& error) {
              line = error.what();
            }
            const bool is_said = is_loopback || is_tunnel || is_secured || (is_private && is_open);
            CAPTURE(is_loopback, is_tunnel, is_private, is_secured, is_open);
            CHECK(line.empty() == is_said);
            if (is_said) continue;
            CHECK(line.find("eth7") != std::string::npos);
            CHECK(line.find("--security FOLDER") != std::string::npos);
            CHECK((line.find("--open") != std::string::npos) == is_private);
            CHECK(line.find('\n') == std::string::npos);
          }
}

TEST_CASE("The configuration is well-formed and says what was asked, whatever names it holds",
          "[network]") {
  std::mt19937 random(GENERATE(range(1U, 9U)));
  for (int i = 0; i < 50; ++i) {
    NetworkOptions options;
    options.interface = hostile_text(random);
    for (std::size_t peers = random() % 4; peers > 0; --peers)
      options.peers.push_back(hostile_text(random));
    const std::string folder = hostile_text(random);
    if (i % 2 == 0) options.security = "/" + folder;
    const Interface interface { "10.3.0.7", false, false, true };
    const auto domain = parsed(configuration_of(options, interface));
    CHECK(interface_of(domain) == options.interface);
    CHECK(peers_of(domain) == options.peers);
    CHECK(domain.get<std::string>("General.AllowMulticast") ==
          (options.peers.empty() ? "spdp" : "false"));
    CHECK(domain.count("Security") == (i % 2 == 0 ? 1 : 0));
    if (i % 2 == 0)
      CHECK(domain.get<std::string>("Security.Authentication.PrivateKey") ==
            "file:" + (options.security / "key.pem").string());
  }
}

TEST_CASE("On the loopback nothing is asked of the network", "[network]") {
  NetworkOptions options;
  options.interface = GENERATE("", "lo");
  const auto domain = parsed(configuration_of(options, {"127.0.0.1", true, false, false}));
  CHECK(interface_of(domain) == "lo");
  CHECK(domain.get<std::string>("General.AllowMulticast") == "false");
  CHECK(peers_of(domain) == std::vector<std::string>{"localhost"});
}

}  // namespace stillgrid::scene_relay::network_test
