#pragma once

#include <catch2/catch.hpp>
#include <cstdint>
#include <numeric>
#include <vector>

#include "sim_server/contact/predicted_contacts.hpp"

namespace stillgrid::contact {

/// All contacts that may touch within step_s, those of the tool last.
[[nodiscard]] inline std::vector<Contact> contacts_within(
    const bodies::World& world, double step_s, const std::vector<ToolSphereMotion>& tool = {}) {
  std::vector<std::uint32_t> all(world.spheres.size());
  std::iota(all.begin(), all.end(), 0U);
  PredictedContacts search;
  REQUIRE(search.find(world, Detection(world, 1.0), all, step_s, tool));
  return search.contacts();
}

}  // namespace stillgrid::contact
