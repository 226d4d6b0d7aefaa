#include "sim_server/dynamics/step/predicted_part.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "sim_server/bodies/joints.hpp"

namespace stillgrid::dynamics {

void PredictedPart::choose(const bodies::World& world,
                           std::span<const bodies::SphereMotion> motions,
                           std::span<const contact::ToolSphereMotion> tool) {
  whole_ = &world;
  is_whole_ = world.spheres.size() <= kMaxSpheres;
  if (is_whole_) {
    spheres_.resize(world.spheres.size());
    std::iota(spheres_.begin(), spheres_.end(), 0U);
    return;
  }
  choose_bodies(motions, tool);
  spheres_.clear();
  part_.gravity_m_s2 = world.gravity_m_s2;
  part_.time_s = world.time_s;
  part_.nodes.clear();
  part_.springs.clear();
  part_.joints.clear();
  part_.rigid_bodies.clear();
  part_.spheres.clear();
  part_.bodies.clear();
  part_.fields =
      world.fields;  // by the same numbers; those of bodies that are left out meet no one
  for (bodies::FieldBody& field : part_.fields) field.rigid = -1;
  for (const auto& [body, stays] : chosen_) add_body(body, stays);
  for (const bodies::Joint& joint : world.joints) add_joint(joint);
  bodies::number_unknowns(part_);
}

/// The nearest first, at least one; of bodies that are as near the first of the scene.
void PredictedPart::choose_bodies(std::span<const bodies::SphereMotion> motions,
                                  std::span<const contact::ToolSphereMotion> tool) {
  bodies_.clear();
  for (std::size_t body = 0; body < whole_->bodies.size(); ++body) {
    const bodies::BodyRange& range = whole_->bodies[body];
    double nearest_m2 = std::numeric_limits<double>::infinity();
    for (int i = range.first_sphere; i < range.first_sphere + range.sphere_count; ++i)
      for (const contact::ToolSphereMotion& sphere : tool)
        nearest_m2 = std::min(
            nearest_m2,
            (motions[static_cast<std::size_t>(i)].position_m - sphere.position_m).squaredNorm());
    if (range.sphere_count > 0) bodies_.emplace_back(nearest_m2, static_cast<std::uint32_t>(body));
  }
  // Each has a sphere at least: no more than these can be chosen.
  const auto most = static_cast<std::ptrdiff_t>(std::min(2 * kMaxSpheres, bodies_.size()));
  if (most < static_cast<std::ptrdiff_t>(bodies_.size()))
    std::nth_element(bodies_.begin(), bodies_.begin() + most, bodies_.end());
  std::sort(bodies_.begin(), bodies_.begin() + most);
  chosen_.clear();
  std::size_t spheres = 0;
  for (std::ptrdiff_t i = 0; i < most; ++i) {
    const std::uint32_t body = bodies_[static_cast<std::size_t>(i)].second;
    spheres += static_cast<std::size_t>(whole_->bodies[body].sphere_count);
    if (i > 0 && spheres > 2 * kMaxSpheres) break;
    chosen_.emplace_back(body, i > 0 && spheres > kMaxSpheres);
  }
  std::sort(chosen_.begin(), chosen_.end());
}

void PredictedPart::add_body(std::size_t number, bool stays) {
  const bodies::BodyRange& from = whole_->bodies[number];
  bodies::BodyRange& body = part_.bodies.emplace_back();
  body.is_sleeping = from.is_sleeping || stays;
  body.node_count = from.node_count;
  body.spring_count = from.spring_count;
  body.sphere_count = from.sphere_count;
  body.first_node = static_cast<int>(part_.nodes.size());
  body.first_spring = static_cast<int>(part_.springs.size());
  body.first_sphere = static_cast<int>(part_.spheres.size());
  const auto append = [](auto& to, const auto& items, int first, int count) {
    to.insert(to.end(), items.begin() + first, items.begin() + first + count);
  };
  append(part_.nodes, whole_->nodes, from.first_node, from.node_count);
  append(part_.springs, whole_->springs, from.first_spring, from.spring_count);
  append(part_.spheres, whole_->spheres, from.first_sphere, from.sphere_count);
  if (from.rigid >= 0) {
    body.rigid = static_cast<int>(part_.rigid_bodies.size());
    part_.rigid_bodies.push_back(whole_->rigid_bodies[static_cast<std::size_t>(from.rigid)]);
  }
  for (std::size_t i = 0; i < part_.fields.size(); ++i) {
    if (whole_->fields[i].body != static_cast<int>(number)) continue;
    part_.fields[i].body = static_cast<int>(part_.bodies.size()) - 1;
    if (whole_->fields[i].rigid >= 0) part_.fields[i].rigid = body.rigid;
  }
  const int moved = body.first_node - from.first_node;
  for (int i = 0; i < body.spring_count; ++i) {
    bodies::Spring& spring = part_.springs[static_cast<std::size_t>(body.first_spring + i)];
    spring.a += moved;
    spring.b += moved;
  }
  for (int i = 0; i < body.sphere_count; ++i) {
    bodies::SphereBinding& sphere = part_.spheres[static_cast<std::size_t>(body.first_sphere + i)];
    spheres_.push_back(static_cast<std::uint32_t>(from.first_sphere + i));
    sphere.body = static_cast<int>(part_.bodies.size()) - 1;
    if (sphere.rigid >= 0) sphere.rigid = body.rigid;
    for (int k = 0; k < sphere.node_count; ++k) sphere.nodes[static_cast<std::size_t>(k)] += moved;
  }
}

/// What is left out stands where it is.
void PredictedPart::add_joint(bodies::Joint joint) {
  bool is_near = false;
  for (bodies::JointEnd* end : {&joint.a, &joint.b}) {
    const auto own = std::ranges::find(chosen_, static_cast<std::uint32_t>(end->body),
                                       &std::pair<std::uint32_t, bool>::first);
    if (end->body < 0 || own == chosen_.end()) {
      const bodies::EndMotion still = bodies::end_motion(*end, whole_->nodes, whole_->rigid_bodies);
      *end = {.point_m = still.centre_m + still.arm_m};
      continue;
    }
    is_near = true;
    const int body = static_cast<int>(own - chosen_.begin());
    const bodies::BodyRange& range = part_.bodies[static_cast<std::size_t>(body)];
    if (end->node >= 0)
      end->node +=
          range.first_node - whole_->bodies[static_cast<std::size_t>(end->body)].first_node;
    if (end->rigid >= 0) end->rigid = range.rigid;
    end->body = body;
  }
  if (joint.a.node < 0 && joint.b.node >= 0) std::swap(joint.a, joint.b);
  if (is_near) part_.joints.push_back(joint);
}

std::span<const contact::Contact> PredictedPart::renumbered(
    std::span<const contact::Contact> contacts) {
  if (is_whole_) return contacts;
  const auto place_of = [&](int sphere) {
    if (bodies::is_field(*whole_, sphere))
      return bodies::number_of_field(part_,
                                     static_cast<std::size_t>(sphere) - whole_->spheres.size());
    const auto at =
        std::lower_bound(spheres_.begin(), spheres_.end(), static_cast<std::uint32_t>(sphere));
    return static_cast<int>(at - spheres_.begin());
  };
  contacts_.assign(contacts.begin(), contacts.end());
  for (contact::Contact& contact : contacts_) {
    contact.a = place_of(contact.a);
    if (contact.b >= 0) contact.b = place_of(contact.b);
  }
  return contacts_;
}

}  // namespace stillgrid::dynamics
