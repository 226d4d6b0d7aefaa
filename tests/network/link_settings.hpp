#pragma once

#include <string>

namespace stillgrid::network {

/// What a link does to the packets of one direction. Shares are of packets, in [0, 1], drawn for
/// each by itself.
struct LinkSettings {
  double delay_ms = 0.0;
  double jitter_ms = 0.0;  // a further delay that wanders between 0 and this; keeps the order
  double loss = 0.0;
  double duplicate = 0.0;
  double reorder = 0.0;  // held back by reorder_ms, so that later ones overtake
  double reorder_ms = 2.0;
  double corrupt = 0.0;          // of UDP: two bits of the payload are flipped, see flip_unseen()
  double rate_Mbit_per_s = 0.0;  // 0: no limit; what would wait longer than 100 ms is dropped
  bool is_partitioned = false;   // nothing enters; what is on its way arrives
};

/// Changes one setting by its key: delay_ms, jitter_ms, loss, duplicate, reorder, reorder_ms,
/// corrupt, rate_mbit_per_s (numbers) or partition (on, off). Throws std::runtime_error, which
/// names key, value and what was expected.
void apply_setting(LinkSettings& settings, const std::string& key, const std::string& value);

}  // namespace stillgrid::network
