#include "sim_server/dynamics/forces/spring_layout.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid::dynamics {
namespace {

/// From a node to the other end of its springs, columns and rows. The second diagonal is joined
/// from its right end.
struct Step {
  int x, y;
};
constexpr std::array<Step, kSpringKinds> kSteps = {
    {{1, 0}, {0, 1}, {1, 1}, {-1, 1}, {2, 0}, {0, 2}}};

/// Alike up to rounding.
bool alike(double a, double b) {
  return std::abs(a - b) <= 1e-12 * std::max(std::abs(a), std::abs(b));
}

using Kinds = std::array<SpringKind, kSpringKinds>;

/// The kinds of a sheet's springs if each is there everywhere or nowhere, and alike everywhere.
std::optional<Kinds> kinds_of(const bodies::World& world, const bodies::BodyRange& body) {
  const int columns = body.sheet_nodes.x(), rows = body.sheet_nodes.y();
  if (columns < 1 || columns * rows != body.node_count) return std::nullopt;
  Kinds kinds;
  std::vector<std::uint8_t> seen(kSpringKinds * static_cast<std::size_t>(body.node_count));
  std::array<int, kSpringKinds> counts{};
  for (int i = body.first_spring; i < body.first_spring + body.spring_count; ++i) {
    const bodies::Spring& spring = world.springs[static_cast<std::size_t>(i)];
    const int from = std::min(spring.a, spring.b) - body.first_node;
    const int to = std::max(spring.a, spring.b) - body.first_node;
    const Step step{to % columns - from % columns, to / columns - from / columns};
    const auto found = std::find_if(kSteps.begin(), kSteps.end(), [&](const Step& known) {
      return known.x == step.x && known.y == step.y;
    });
    if (found == kSteps.end()) return std::nullopt;
    const auto kind = static_cast<std::size_t>(found - kSteps.begin());
    std::uint8_t& place = seen[kSpringKinds * static_cast<std::size_t>(from) + kind];
    if (place++ != 0) return std::nullopt;
    if (counts[kind]++ == 0)
      kinds[kind] = {spring.stiffness_N_per_m, spring.rest_length_m, spring.damping_N_s_per_m};
    if (!alike(kinds[kind].stiffness_N_per_m, spring.stiffness_N_per_m) ||
        !alike(kinds[kind].rest_length_m, spring.rest_length_m) ||
        !alike(kinds[kind].damping_N_s_per_m, spring.damping_N_s_per_m))
      return std::nullopt;
  }
  for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
    const int all =
        std::max(0, columns - std::abs(kSteps[kind].x)) * std::max(0, rows - kSteps[kind].y);
    if (counts[kind] != 0 && counts[kind] != all) return std::nullopt;
  }
  return kinds;
}

}  // namespace

std::optional<SpringSheet> sheet_of(const bodies::World& world, std::size_t index) {
  const bodies::BodyRange& body = world.bodies[index];
  const std::optional<Kinds> kinds = kinds_of(world, body);
  if (!kinds) return std::nullopt;
  SpringSheet sheet;
  sheet.body = index;
  sheet.first_node = static_cast<std::size_t>(body.first_node);
  sheet.columns = static_cast<std::size_t>(body.sheet_nodes.x());
  sheet.rows = static_cast<std::size_t>(body.sheet_nodes.y());
  // An odd number of cache lines, so that rows do not compete for the same ones.
  sheet.stride =
      contact::kLanes * (((sheet.columns + contact::kLanes - 1) / contact::kLanes + 2) | 1U);
  sheet.storage.resize(SheetRows::count(sheet.rows) * sheet.stride / contact::kLanes);
  const SheetRows rows(sheet);
  // Beyond the last column stand nodes that are nowhere near, so that lengths are numbers.
  for (std::size_t row = 0; row < sheet.rows + 2; ++row)
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t i = 0; i < sheet.stride - contact::kLanes; ++i)
        *rows[SheetRows::of_nodes(row) + axis].at(i) = 1e3 * static_cast<double>(i + 1);
  sheet.kinds = *kinds;
  for (const SpringKind& kind : *kinds) sheet.damped = sheet.damped || kind.damping_N_s_per_m > 0.0;
  return sheet;
}

SpringGroup group_of(const bodies::World& world, std::size_t index) {
  const bodies::BodyRange& body = world.bodies[index];
  SpringGroup group;
  group.body = index;
  const auto count = static_cast<std::size_t>(body.spring_count);
  const std::size_t stride = (count + contact::kLanes - 1) / contact::kLanes;
  for (std::size_t k = 0; k < contact::kLanes * stride; ++k) {
    // Those of a look are far apart in the list.
    const std::size_t i = (k % contact::kLanes) * stride + k / contact::kLanes;
    bodies::Spring spring{body.first_node, body.first_node, 0.0, 0.0, 0.0};
    if (i < count) spring = world.springs[static_cast<std::size_t>(body.first_spring) + i];
    group.a.push_back(static_cast<std::uint32_t>(spring.a));
    group.b.push_back(static_cast<std::uint32_t>(spring.b));
    group.stiffness_N_per_m.push_back(spring.stiffness_N_per_m);
    group.push_N.push_back(spring.stiffness_N_per_m * spring.rest_length_m);
    group.damping_N_s_per_m.push_back(spring.damping_N_s_per_m);
    group.damped = group.damped || spring.damping_N_s_per_m > 0.0;
  }
  return group;
}

}  // namespace stillgrid::dynamics
