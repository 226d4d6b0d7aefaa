#pragma once

#include <cstddef>

#include "shared/dynamics/contact_row.hpp"

namespace stillgrid::dynamics {

/// State of a contact between substeps. Impulses and stretches act on side a.
struct ContactHistory {
  float push_impulse_N_s = 0.0F, friction_impulse_N_s[3] = {}, stretch_m[3] = {};
};

[[nodiscard]] inline ContactHistory history_of(const ContactRow& row, const RowPlace& place,
                                               std::size_t lane) {
  ContactHistory history{.push_impulse_N_s = row.push_impulse_N_s[lane]};
  for (std::size_t k = 0; k < 3; ++k) {
    history.friction_impulse_N_s[k] = row.friction_impulse_N_s[k][lane];
    history.stretch_m[k] = place.stretch_m[k][lane];
  }
  return history;
}

inline void set_history(const ContactHistory& history, ContactRow& row, RowPlace& place,
                        std::size_t lane) {
  row.push_impulse_N_s[lane] = history.push_impulse_N_s;
  for (std::size_t k = 0; k < 3; ++k) {
    row.friction_impulse_N_s[k][lane] = history.friction_impulse_N_s[k];
    place.stretch_m[k][lane] = history.stretch_m[k];
  }
}

}  // namespace stillgrid::dynamics
