#include "tests/network/link_settings.hpp"

#include <array>
#include <cstdlib>
#include <stdexcept>

#include "shared/command_line/number_in.hpp"

namespace stillgrid::network {
namespace {

struct Key {
  const char* name;
  double LinkSettings::*member;
  double high;
};

constexpr double kLongest_ms = 10'000.0;

constexpr std::array<Key, 8> kKeys = {{{"delay_ms", &LinkSettings::delay_ms, kLongest_ms},
                                       {"jitter_ms", &LinkSettings::jitter_ms, kLongest_ms},
                                       {"loss", &LinkSettings::loss, 1.0},
                                       {"duplicate", &LinkSettings::duplicate, 1.0},
                                       {"reorder", &LinkSettings::reorder, 1.0},
                                       {"reorder_ms", &LinkSettings::reorder_ms, kLongest_ms},
                                       {"corrupt", &LinkSettings::corrupt, 1.0},
                                       {"rate_mbit_per_s", &LinkSettings::rate_Mbit_per_s, 1e6}}};

}  // namespace

void apply_setting(LinkSettings& settings, const std::string& key, const std::string& value) {
  if (key == "partition") {
    if (value != "on" && value != "off")
      throw std::runtime_error("partition: value '" + value + "': expected on or off");
    settings.is_partitioned = value == "on";
    return;
  }
  for (const Key& known : kKeys) {
    if (key != known.name) continue;
    std::string text = value;
    std::string wrong = command_line::number_in(0.0, known.high)(text);
    if (!wrong.empty()) throw std::runtime_error(wrong.insert(0, key + ": "));
    settings.*known.member = std::strtod(value.c_str(), nullptr);
    return;
  }
  std::string names = "partition";
  for (const Key& known : kKeys) names += std::string(", ") + known.name;
  throw std::runtime_error("key '" + key + "': expected one of " + names);
}

}  // namespace stillgrid::network
