#include "sim_server/bodies/kinds/thread.hpp"

#include <array>
#include <string_view>

#include "sim_server/bodies/kinds/body_description.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::bodies {
namespace {

constexpr int kMaxNodes = 1000;
constexpr std::array<std::string_view, 4> kPins = {"none", "start", "end", "both"};

std::vector<int> read_pins(toml::TableReader& table, int nodes) {
  const std::string_view where = kPins[table.choice("pinned", kPins)];
  std::vector<int> pinned;
  if (where == "start" || where == "both") pinned.push_back(0);
  if (where == "end" || where == "both") pinned.push_back(nodes - 1);
  return pinned;
}

double length_m(const ThreadBody& thread) {
  return (thread.to_m - thread.from_m).norm();
}

/// As described, or a sphere a node.
SpherePacking packing_of(const ThreadBody& thread) {
  return completed(thread.spheres, length_m(thread) / (thread.nodes - 1));
}

}  // namespace

void read_thread(toml::TableReader& table, BodyDescription& body,
                 std::vector<std::string>& /*notes*/) {
  ThreadBody thread;
  thread.nodes = table.integer("nodes", {2, kMaxNodes});
  thread.from_m = table.vector("from_m");
  thread.to_m = table.vector("to_m");
  if (length_m(thread) < 1e-9) table.refuse("to_m", "another point than from_m");
  body.position_m = 0.5 * (thread.from_m + thread.to_m);
  thread.spheres = read_packing(table, length_m(thread));
  thread.spheres = packing_of(thread);
  read_springs(table, body.motion, thread.springs);
  thread.springs.pinned_nodes =
      read_pinned(table, thread.nodes, [&] { return read_pins(table, thread.nodes); });
  body.shape = std::move(thread);
}

BodyCounts counts_of(const ThreadBody& thread) {
  const double bend = thread.springs.bend_stiffness_N_per_m > 0.0 ? 1.0 : 0.0;
  const double nodes = thread.nodes;
  return {.spheres = spheres_along(length_m(thread), packing_of(thread).spacing_m),
          .nodes = nodes,
          .springs = nodes * (1.0 + bend)};
}

/// Structural springs join neighbours, bend springs every second node.
SpringNet net_of(const ThreadBody& thread, const BodyDescription& /*body*/) {
  SpringNet net;
  for (int x = 0; x < thread.nodes; ++x) {
    const double u = thread.nodes > 1 ? double(x) / double(thread.nodes - 1) : 0.0;
    net.nodes_m.emplace_back(thread.from_m + u * (thread.to_m - thread.from_m));
  }
  const auto join = [&](int x, int dx, double stiffness_N_per_m) {
    if (x + dx < thread.nodes) net.links.push_back({x, x + dx, stiffness_N_per_m});
  };
  for (int x = 0; x < thread.nodes; ++x) {
    join(x, 1, thread.springs.structural_stiffness_N_per_m);
    join(x, 2, thread.springs.bend_stiffness_N_per_m);
  }
  return net;
}

std::vector<SphereBinding> spheres_of(const ThreadBody& thread, const BodyDescription& /*body*/) {
  const auto [spacing_m, radius_m] = packing_of(thread);
  const int count = count_along(length_m(thread), spacing_m);
  std::vector<SphereBinding> spheres;
  for (int i = 0; i < count; ++i) {
    SphereBinding& sphere = spheres.emplace_back();
    sphere.radius_m = radius_m;
    const auto [lower, t] = among_nodes(i, count, thread.nodes);
    bind(sphere, lower, 1.0 - t);
    bind(sphere, lower + 1, t);
    sphere.rest_position_m =
        thread.from_m + spread(i, count, 0.0, 1.0) * (thread.to_m - thread.from_m);
  }
  return spheres;
}

BodySurface surface_of(const ThreadBody& /*thread*/, const BodyDescription& /*body*/,
                       const RestSpheres& spheres) {
  return grid_surface(spheres, 1);
}

}  // namespace stillgrid::bodies
