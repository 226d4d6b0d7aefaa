#include "sim_server/bodies/kinds/springs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::bodies {
namespace {

constexpr std::string_view kStiffness = "spring_stiffness_N_per_m";

void read_structural(toml::TableReader& stiffness, Motion motion, SpringDescription& springs) {
  if (motion == Motion::kFree || stiffness.has("structural"))
    springs.structural_stiffness_N_per_m = stiffness.number("structural", toml::Bound::kPositive);
}

void read_others(toml::TableReader& table, toml::TableReader& stiffness,
                 SpringDescription& springs) {
  springs.bend_stiffness_N_per_m = stiffness.number_or("bend", toml::Bound::kNotNegative, 0.0);
  stiffness.finish();
  springs.spring_damping_N_s_per_m =
      table.number_or("spring_damping_N_s_per_m", toml::Bound::kNotNegative, 0.0);
  if (!table.has("spring_rest_ratio")) return;
  springs.spring_rest_ratio = table.has_number("spring_rest_ratio")
                                  ? table.number("spring_rest_ratio", toml::Bound::kAny)
                                  : 0.0;
  if (!(springs.spring_rest_ratio >= 0.1 && springs.spring_rest_ratio <= 10.0))
    table.refuse("spring_rest_ratio", "a number from 0.1 to 10");
}

std::vector<int> read_list(toml::TableReader& table, int node_count) {
  std::vector<int> pinned = table.integers("pinned", {0, node_count - 1});
  std::sort(pinned.begin(), pinned.end());
  pinned.erase(std::unique(pinned.begin(), pinned.end()), pinned.end());
  return pinned;
}

double stiffness_of(LatticeLink link, const ShearSprings& springs) {
  if (link == LatticeLink::kStructural) return springs.structural_stiffness_N_per_m;
  return link == LatticeLink::kShear ? springs.shear_stiffness_N_per_m
                                     : springs.bend_stiffness_N_per_m;
}

}  // namespace

void read_springs(toml::TableReader& table, Motion motion, SpringDescription& springs) {
  toml::TableReader stiffness = table.table(kStiffness);
  read_structural(stiffness, motion, springs);
  read_others(table, stiffness, springs);
}

void read_springs(toml::TableReader& table, Motion motion, ShearSprings& springs) {
  toml::TableReader stiffness = table.table(kStiffness);
  read_structural(stiffness, motion, springs);
  springs.shear_stiffness_N_per_m = stiffness.number_or("shear", toml::Bound::kNotNegative, 0.0);
  read_others(table, stiffness, springs);
}

std::vector<int> read_pinned(toml::TableReader& table, int node_count,
                             const std::function<std::vector<int>()>& by_name) {
  if (!table.has("pinned")) return {};
  return table.has_text("pinned") ? by_name() : read_list(table, node_count);
}

std::vector<int> read_pinned_in_solid(toml::TableReader& table, const SoftLattice& lattice,
                                      const Eigen::Vector3d& position_m,
                                      const Eigen::Quaterniond& orientation) {
  if (!table.has("pinned")) return {};
  if (table.has_text("pinned")) {
    constexpr std::array<std::string_view, 1> none = {"none"};
    (void)table.choice("pinned", none);
    return {};
  }
  if (!table.has_table("pinned")) return read_list(table, static_cast<int>(lattice.nodes_m.size()));
  toml::TableReader box = table.table("pinned");
  const Eigen::Vector3d low_m = box.vector("low_m"), high_m = box.vector("high_m");
  box.finish();
  std::vector<int> pinned;
  for (std::size_t i = 0; i < lattice.nodes_m.size(); ++i) {
    const Eigen::Array3d at_m = position_m + orientation * lattice.nodes_m[i];
    if ((at_m >= low_m.array()).all() && (at_m <= high_m.array()).all())
      pinned.push_back(static_cast<int>(i));
  }
  if (pinned.empty()) table.refuse("pinned", "a box with a node of the body in it");
  return pinned;
}

double crushing_force_N(const SoftLattice& lattice, const ShearSprings& springs) {
  constexpr double kSpringsBelowATool = 2.0;
  return kSpringsBelowATool * springs.structural_stiffness_N_per_m * lattice.spacing_m.minCoeff();
}

std::string note_of_crushing(const std::string& body, const SoftLattice& lattice,
                             const ShearSprings& springs) {
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "a tool may crush it by more than %.2g N",
                crushing_force_N(lattice, springs));
  return "body '" + body + "': " + text.data();
}

SpringNet net_of_solid(const SoftLattice& lattice, const ShearSprings& springs,
                       const Eigen::Vector3d& position_m, const Eigen::Quaterniond& orientation) {
  SpringNet net;
  for (const Eigen::Vector3d& node_m : lattice.nodes_m)
    net.nodes_m.emplace_back(position_m + orientation * node_m);
  for (const LatticeSpring& spring : lattice_springs(lattice))
    net.links.push_back({spring.a, spring.b, stiffness_of(spring.link, springs)});
  return net;
}

std::vector<SphereBinding> spheres_in_solid(std::span<const spheres::Ball> balls,
                                            const SoftLattice& lattice, const ShearSprings& springs,
                                            const Eigen::Vector3d& position_m,
                                            const Eigen::Quaterniond& orientation) {
  const double most_N = crushing_force_N(lattice, springs);
  std::vector<SphereBinding> spheres;
  for (const spheres::Ball& ball : balls) {
    SphereBinding& sphere = spheres.emplace_back(placed_sphere(ball, position_m, orientation));
    sphere.crushing_force_N = most_N;
    const LatticePoint point = bind_to_lattice(lattice, ball.centre_m);
    for (std::size_t i = 0; i < point.nodes.size(); ++i)
      bind(sphere, point.nodes[i], point.weights[i]);
  }
  return spheres;
}

BodyCounts counts_of_solid(double spheres, const SoftLattice& lattice,
                           const ShearSprings& springs) {
  const double bend = springs.bend_stiffness_N_per_m > 0.0 ? 1.0 : 0.0;
  const double shear = springs.shear_stiffness_N_per_m > 0.0 ? 1.0 : 0.0;
  const auto nodes = static_cast<double>(lattice.nodes_m.size());
  return {.spheres = spheres,
          .nodes = nodes,
          .springs = nodes * (3.0 + 10.0 * shear + 3.0 * bend)};  // where many nodes are round one
}

}  // namespace stillgrid::bodies
