#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sim_server/contact/detection.hpp"
#include "sim_server/contact/field_ways.hpp"

namespace stillgrid::contact {

/// The contacts of a step to come, of some moving spheres. Paths count, not places: two spheres
/// that pass through each other within the step are found. Fields are few and stand beside the
/// grids: each looks for the spheres near it there. Lists last from one search to the next.
class PredictedContacts {
 public:
  /// Makes contacts() what may touch within step_s: the given spheres, ascending, and fields of
  /// their bodies among themselves, with what is static and, last, with the tool. False where these
  /// would be more than 64 pairs or 16 contacts a sphere and something goes farther than its
  /// radius. Pre: detection is of this world, and has seen who sleeps.
  bool find(const bodies::World& world, const Detection& detection,
            std::span<const std::uint32_t> spheres, double step_s,
            const std::vector<ToolSphereMotion>& tool);

  [[nodiscard]] const std::vector<Contact>& contacts() const noexcept { return contacts_; }

 private:
  void take(const bodies::World& world, const Detection& detection,
            std::span<const std::uint32_t> spheres, double step_s);
  void add_fields(const bodies::World& world, const Detection& detection);
  [[nodiscard]] bool is_known(const bodies::World& world, std::size_t field) const;
  [[nodiscard]] Mover mover(std::uint32_t k) const { return {spheres_[k], motion_[k], ways_[k]}; }

  std::vector<std::uint32_t> spheres_;  // numbers of World::spheres; what follows: of each of them
  std::vector<bodies::SphereMotion> motion_;
  std::vector<collision::SweptBound> ways_;
  std::unique_ptr<MovingSpheres> moving_;
  std::vector<char> has_body_;  // of each body: its spheres are among them
  std::optional<FieldWays> fields_;
  std::vector<Contact> contacts_;
  std::vector<std::uint32_t> met_;
};

}  // namespace stillgrid::contact
