#pragma once

#include <vector>

#include "shared/dynamics/contact_listing.hpp"
#include "shared/dynamics/contact_row.hpp"
#include "shared/dynamics/description.hpp"
#include "shared/dynamics/field_geometry.hpp"
#include "shared/dynamics/scene_state.hpp"

namespace stillgrid::dynamics {

/// Evaluates the fields of listed contacts. Rows know spheres only. Each contact with a field has
/// its own SpherePlace and SphereArm, behind those of spheres. This class sets them to the tangent
/// sphere.
///
/// Thread: one.
class FieldContacts {
 public:
  explicit FieldContacts(const Description& description)
      : description_(description), poses_(description.fields.size()) {}

  /// Whether no field leaves its reach within a tick.
  [[nodiscard]] bool stay_within(const ContactListing& listing, const SceneState& state,
                                 double tick_s) const;
  /// Returns the longest path of a sphere in a tick relative to a field that it may meet, at least
  /// `least`. The unit is the length of the sphere or the cell of the field, whichever is shorter.
  [[nodiscard]] double most_lengths(const ContactListing& listing, const SceneState& state,
                                    double tick_s, double least) const;
  /// Makes room for the contacts of a new listing.
  void adopt(const ContactListing& listing, ContactBodies& bodies) const;
  /// Sets tangent spheres and stiffness at the poses of the state. Friction's springs keep their
  /// energy. Pre: the places of spheres are set.
  void place(ContactListing& listing, const SceneState& state, ContactBodies& bodies,
             double substep_s);
  /// Takes the map's scale out of friction's springs, until place() is called again.
  static void finish(ContactListing& listing);
  /// Returns the energy of the springs of listed contacts with fields and of their friction. rigid:
  /// of those of one rigid body; -1: of all.
  [[nodiscard]] double energy_J(const ContactListing& listing, const SceneState& state,
                                int rigid) const;

 private:
  struct Pose {
    FieldPose pose;
    float margin_m = 0.0F;  // how far any point may move within a substep
  };
  const Description& description_;
  std::vector<Pose> poses_;  // one for each field
};

}  // namespace stillgrid::dynamics
