#pragma once

#include "sim_server/contact/contact.hpp"
#include "sim_server/contact/crossing.hpp"

namespace stillgrid::contact {

/// Whether one side of a contact is a field.
[[nodiscard]] inline bool is_of_field(const Ways& ways, const Contact& contact) noexcept {
  return ways.world != nullptr && (bodies::is_field(*ways.world, contact.a) ||
                                   (contact.b >= 0 && bodies::is_field(*ways.world, contact.b)));
}

/// How deep a sphere comes into a field on its way, seen from the field's body.
struct FieldPassage {
  double deepest_m = 0.0;  // negative: a gap, at least as wide
  bool passes = false;     // its end tells nothing of it, or pushes on: out of the other side
  double stop = 1.0;       // the share of the way that leads to half of that depth, if it passes
};
/// The way is looked at in steps as long as the distance to the solid allows, in it of half a fine
/// cell and half a radius. Realtime: yes. Pre: is_of_field(). A graze is no passage.
[[nodiscard]] FieldPassage passage_of(const Contact& contact, const Ways& ways) noexcept;

/// share_before_crossing() of a contact with a field.
[[nodiscard]] double share_before_field(const Contact& contact, const Ways& ways) noexcept;

/// meet() of a contact with a field.
[[nodiscard]] bool meets_field(const Contact& contact, const Ways& ways) noexcept;

}  // namespace stillgrid::contact
