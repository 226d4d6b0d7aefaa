#include "sim_server/dynamics/choice/memory_need.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <stdexcept>

#include "shared/collision/voxel_grid.hpp"
#include "sim_server/bodies/kinds/body_in_world.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr double kMaxSpheres = 1e6;

// Bytes that one of each takes: in the world, in trials and packed copies, in lists of contacts.
constexpr double kStaticBodyBytes = 2500.0, kNodeBytes = 480.0, kSpringBytes = 110.0;
// A free body may lie in a pile: pairs, rows and what sticks of up to twelve that it touches.
constexpr double kBodyBytes = 5000.0;
constexpr double kSphereBytes = 900.0, kStaticSphereBytes = 400.0;
// A point that bodies are joined at, its Jacobian too.
constexpr double kJointBytes = 2500.0;
// More of an implicit step: Jacobians of a spring, vectors of a node.
constexpr double kSpringJacobianBytes = 450.0, kNodeVectorBytes = 700.0;

/// What spheres take of one slot of a segment.
double slot_bytes(double spheres) {
  const auto count = static_cast<std::size_t>(spheres);
  return 8.0 * static_cast<double>(collision::grid_layout(0, count).total_words -
                                   collision::grid_layout(0, 0).total_words);
}

std::string size_text(double bytes) {
  std::array<char, 40> text{};
  const bool is_giga = bytes >= 1e9;
  const double size = (is_giga ? 1e-9 : 1e-6) * bytes;
  std::snprintf(text.data(), text.size(), size < 10.0 || is_giga ? "%.1f %s" : "%.0f %s", size,
                is_giga ? "GB" : "MB");
  return text.data();
}

[[noreturn]] void refuse(const bodies::BodyDescription& body, const std::string& file,
                         const std::string& what) {
  throw std::runtime_error(file + ":" + std::to_string(body.line) + ": body '" + body.name +
                           "': " + what);
}

}  // namespace

Memory memory_need(const bodies::BodyDescription& body, const scene::Method& method) {
  const auto [spheres, nodes, springs, field] = bodies::counts_of(body);
  const double slot = slot_bytes(std::min(spheres, kMaxSpheres));
  if (body.motion == bodies::Motion::kStatic)
    return {kStaticBodyBytes + kStaticSphereBytes * spheres + 2.0 * slot + field, slot + field};
  Memory need{kBodyBytes + kSphereBytes * spheres + kNodeBytes * nodes + kSpringBytes * springs +
                  slot + field,
              2.0 * slot + field};
  if (scene::is_explicit(method.integrator)) return need;
  need.private_bytes += kNodeVectorBytes * nodes + kSpringJacobianBytes * springs;
  return need;
}

void require_room(const scene::SceneDescription& scene, const std::string& file,
                  const Memory& available) {
  const auto hands = static_cast<double>(std::max<std::size_t>(1, scene.hands.size()));
  double spheres = 0.0;
  Memory total, most;
  for (const scene::JointDescription& joint : scene.joints)
    total.private_bytes += kJointBytes * static_cast<double>(joint.points_m.size());
  const bodies::BodyDescription *largest = nullptr, *most_shared = nullptr;
  for (const bodies::BodyDescription& body : scene.bodies) {
    const double count = bodies::counts_of(body).spheres;
    spheres += count;
    if (spheres > kMaxSpheres)
      refuse(body, file,
             "spheres: value " + std::to_string(static_cast<std::uint64_t>(std::min(count, 1e18))) +
                 ": expected at most 1000000 in a scene; give it a larger spacing_m");
    const Memory need = memory_need(body, scene.method);
    total.private_bytes += need.private_bytes;
    total.shared_bytes += hands * need.shared_bytes;
    if (need.private_bytes > most.private_bytes) {
      most.private_bytes = need.private_bytes;
      largest = &body;
    }
    if (hands * need.shared_bytes > most.shared_bytes) {
      most.shared_bytes = hands * need.shared_bytes;
      most_shared = &body;
    }
  }
  const auto check = [&](const bodies::BodyDescription* body, double own, double all, double left,
                         const std::string& where) {
    if (body == nullptr || all <= left) return;
    refuse(*body, file,
           "memory: value " + size_text(own) + " of about " + size_text(all) +
               " that the scene takes: expected at most " + size_text(left) + ", what " + where +
               " has left; fewer nodes or spheres, or an explicit integrator, take less");
  };
  check(largest, most.private_bytes, total.private_bytes, available.private_bytes, "this machine");
  check(most_shared, most.shared_bytes, total.shared_bytes, available.shared_bytes, "/dev/shm");
}

}  // namespace stillgrid::dynamics
