#include "sim_server/contact/detection.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "shared/collision/grid_query.hpp"

namespace stillgrid::contact {
namespace {

/// Slack round a sphere's predicted path, of its radius: what a push within the step may add.
constexpr double kMargin = 0.1;
/// Bounding radius of a path over the radius from which on a sphere is fast: half of its way, and
/// the slack.
constexpr double kFastBound = 0.5 + 1.0 + kMargin;
/// Pairs and contacts that a step may list for each sphere, and for all, however fast they are.
constexpr std::size_t kPairsPerSphere = 64, kContactsPerSphere = 16, kFreePairs = 20'000;
/// Half of a path that only a state that is lost takes, and whose square is still a float's.
constexpr float kLost_m = 1e13F;
/// Squares whose roots are within a float's range, by far.
constexpr double kLarge = 1e60;

/// Edge of the static grid's voxels, over twice its swept bounds' radius, where the scene asks for
/// none.
constexpr float kStaticRatio = 1.5F;

/// A sphere where it is, in a grid's floats.
collision::SweptBound ball_of(const Eigen::Vector3d& centre_m, double radius_m) {
  const Eigen::Vector3f c = centre_m.cast<float>();
  return {{c.x(), c.y(), c.z()}, static_cast<float>(radius_m)};
}

/// Swept bounds of the spheres that never move, as a reader of their published floats would make
/// them.
std::vector<collision::SweptBound> static_bounds(const bodies::World& world) {
  std::vector<collision::SweptBound> swept_bounds;
  for (const bodies::StaticSphere& sphere : world.static_spheres)
    swept_bounds.push_back(collision::bound_sphere(sphere.position_m.cast<float>().cast<double>(),
                                                   static_cast<float>(sphere.radius_m)));
  return swept_bounds;
}

/// Its place among the spheres of its body tells a user more than its number in the scene.
[[noreturn]] void refuse(const bodies::World& world, std::size_t sphere,
                         const bodies::SphereMotion& motion) {
  const int body = world.spheres[sphere].body;
  std::size_t first = sphere;
  while (first > 0 && world.spheres[first - 1].body == body) --first;
  const Eigen::Vector3d& p = motion.position_m;
  throw std::domain_error("body '" + world.bodies[static_cast<std::size_t>(body)].name +
                          "': sphere " + std::to_string(sphere - first) + ": position " +
                          std::to_string(p.x()) + ", " + std::to_string(p.y()) + ", " +
                          std::to_string(p.z()) + " m after " + std::to_string(world.time_s) +
                          " s: expected finite numbers");
}

const collision::ContactMaterial& material_of(const bodies::World& world, int material) {
  return world.materials[static_cast<std::size_t>(material)];
}

/// What may be listed of a scene without a thought of memory.
std::size_t most_pairs(const bodies::World& world) {
  return kPairsPerSphere * world.spheres.size() + kFreePairs;
}
std::size_t most_contacts(const bodies::World& world) {
  return kContactsPerSphere * world.spheres.size() + kFreePairs;
}

/// Spheres of a rigid body never touch each other, nor do those of all that is prescribed.
std::vector<std::uint32_t> groups_of(const bodies::World& world) {
  constexpr std::uint32_t kPrescribed = 0xffff'fffe;
  std::vector<std::uint32_t> groups;
  for (const bodies::SphereBinding& sphere : world.spheres) {
    if (sphere.rigid < 0)
      groups.push_back(kNoGroup);
    else if (!world.rigid_bodies[static_cast<std::size_t>(sphere.rigid)].free)
      groups.push_back(kPrescribed);
    else
      groups.push_back(static_cast<std::uint32_t>(sphere.rigid));
  }
  return groups;
}

/// A contact of moving sphere i, yet without what it touches.
Contact& add_contact(std::vector<Contact>& contacts, const bodies::World& world, std::uint32_t i) {
  Contact& contact = contacts.emplace_back();
  contact.a = static_cast<int>(i);
  contact.radius_a_m = world.spheres[i].radius_m;
  return contact;
}

}  // namespace

Detection::Detection(const bodies::World& world, double voxel_ratio)
    : self_collision_(world),
      moving_(world.spheres.size(), static_cast<float>(voxel_ratio), groups_of(world)),
      static_(0, world.static_spheres.size()),
      motion_(world.spheres.size()),
      paths_(world.spheres.size()) {
  static_.enter(static_bounds(world),
                voxel_ratio > 0.0 ? static_cast<float>(voxel_ratio) : kStaticRatio);
  for (const bodies::SphereBinding& sphere : world.spheres)
    is_free_.push_back(sphere.rigid < 0 ||
                       world.rigid_bodies[static_cast<std::size_t>(sphere.rigid)].free);
  note_sleep(world);
  std::vector<collision::SweptBound> balls;
  for (std::size_t i = 0; i < world.spheres.size(); ++i)
    balls.push_back(ball_of(motion_[i].position_m, world.spheres[i].radius_m));
  moving_.enter(balls);
}

void Detection::note_sleep(const bodies::World& world) {
  moves_.assign(world.spheres.size(), 1);
  move_spheres(world);
  for (std::size_t i = 0; i < world.spheres.size(); ++i) {
    const bodies::SphereBinding& sphere = world.spheres[i];
    const bool is_sleeping = world.bodies[static_cast<std::size_t>(sphere.body)].is_sleeping;
    moves_[i] = !is_sleeping &&
                (is_free(i) ||
                 bodies::is_moved(world.rigid_bodies[static_cast<std::size_t>(sphere.rigid)]));
    const Eigen::Vector3d& at_m = motion_[i].position_m;
    if (!moves(i))
      paths_[i] = collision::bound_sweep(at_m, at_m, (1.0 + kMargin) * sphere.radius_m);
  }
}

void Detection::move_spheres(const bodies::World& world) {
  bodies::SphereMotions motion_of(world.nodes, world.rigid_bodies);
  for (std::size_t i = 0; i < world.spheres.size(); ++i) {
    if (!moves(i)) continue;
    motion_[i] = motion_of(world.spheres[i]);
    // As published: what is beyond a float's range is as lost as what is no number.
    const auto& [position_m, velocity_m_s] = motion_[i];
    if (position_m.squaredNorm() + velocity_m_s.squaredNorm() < kLarge) continue;
    if (!position_m.cast<float>().allFinite() || !velocity_m_s.cast<float>().allFinite())
      refuse(world, i, motion_[i]);
  }
}

bool Detection::find_contacts(const bodies::World& world, double step_s, bool must) {
  contacts_.clear();
  bound_sweeps(world, step_s);
  if (add_pairs(world, must)) {
    add_static(world);
    if (contacts_.size() <= most_contacts(world) || must || !is_fast(world)) {
      add_planes(world, step_s);
      return true;
    }
  }
  contacts_.clear();
  return false;
}

/// Whether something that moves goes farther within the step than its radius.
bool Detection::is_fast(const bodies::World& world) const {
  for (std::size_t i = 0; i < paths_.size(); ++i)
    if (moves(i) && paths_[i].bounding_radius_m > kFastBound * world.spheres[i].radius_m)
      return true;
  return false;
}

void Detection::bound_sweeps(const bodies::World& world, double step_s) {
  move_spheres(world);
  const Eigen::Vector3d fall_m = step_s * step_s * world.gravity_m_s2;
  for (std::size_t i = 0; i < world.spheres.size(); ++i) {
    if (!moves(i)) continue;
    // Where it is, where it would be without and with its fall: every shorter step ends between
    // them.
    const Eigen::Vector3d& now_m = motion_[i].position_m;
    const Eigen::Vector3d straight_m = now_m + step_s * motion_[i].velocity_m_s;
    const double radius_m = (1.0 + kMargin) * world.spheres[i].radius_m;
    paths_[i] = is_free(i)
                    ? collision::bound_sweep(now_m, straight_m, straight_m + fall_m, radius_m)
                    : collision::bound_sweep(now_m, straight_m, radius_m);
    if (!(paths_[i].bounding_radius_m < kLost_m)) refuse(world, i, motion_[i]);
  }
}

bool Detection::strayed(const bodies::World& world,
                        std::span<const bodies::SphereMotion> end) const {
  for (std::size_t i = 0; i < end.size(); ++i) {
    if (!moves(i) || !is_free(i)) continue;
    const collision::SweptBound& path = paths_[i];
    const Eigen::Vector3d centre_m(path.centre_m[0], path.centre_m[1], path.centre_m[2]);
    // The path's radius has the radius and its slack in it.
    const double within_m = path.bounding_radius_m - world.spheres[i].radius_m;
    if ((end[i].position_m - centre_m).squaredNorm() > within_m * within_m) return true;
  }
  return false;
}

/// False where there would be too many.
bool Detection::add_pairs(const bodies::World& world, bool must) {
  const auto may_collide = [&](std::uint32_t i, std::uint32_t j) {
    return (is_free(i) || is_free(j)) &&
           self_collision_.may_collide(world.spheres[i], world.spheres[j]);
  };
  auto found = moving_.find_at_most(paths_, may_collide, most_pairs(world));
  if (!found || found->size() > most_contacts(world)) {
    if (!must && is_fast(world)) return false;
    found = moving_.find(paths_, may_collide);
  }
  for (const auto& [i, j] : *found) {
    if (!moves(i) && !moves(j)) continue;
    const bodies::SphereBinding &a = world.spheres[i], &b = world.spheres[j];
    Contact& contact = add_contact(contacts_, world, i);
    contact.b = static_cast<int>(j);
    contact.material =
        collision::pair_material(material_of(world, a.material), material_of(world, b.material));
    contact.radius_b_m = b.radius_m;
    contact.depth_before_m =
        a.radius_m + b.radius_m - (motion_[i].position_m - motion_[j].position_m).norm();
  }
  return true;
}

void Detection::add_static(const bodies::World& world) {
  if (world.static_spheres.empty()) return;
  const collision::GridView view = static_.view();
  for (std::uint32_t i = 0; i < world.spheres.size(); ++i) {
    if (!is_free(i) || !moves(i)) continue;
    collision::for_each_candidate(view, paths_[i], collision::kAllVisits, [&](std::uint32_t j) {
      const bodies::StaticSphere& b = world.static_spheres[j];
      Contact& contact = add_contact(contacts_, world, i);
      contact.material = collision::pair_material(material_of(world, world.spheres[i].material),
                                                  material_of(world, b.material));
      contact.radius_b_m = b.radius_m;
      contact.position_b_m = b.position_m;
      contact.start_b_m = b.position_m;
      contact.other = static_cast<int>(j);
      contact.depth_before_m =
          contact.radius_a_m + b.radius_m - (motion_[i].position_m - b.position_m).norm();
    });
  }
}

void Detection::add_planes(const bodies::World& world, double step_s) {
  for (const bodies::StaticPlane& plane : world.planes) {
    const double fall_m = step_s * step_s * plane.normal.dot(world.gravity_m_s2);
    for (std::uint32_t i = 0; i < world.spheres.size(); ++i) {
      if (!is_free(i) || !moves(i)) continue;
      const double height_m = plane.normal.dot(motion_[i].position_m) - plane.offset_m;
      const double move_m = step_s * plane.normal.dot(motion_[i].velocity_m_s);
      const double lowest_m = height_m + std::min({0.0, move_m, move_m + fall_m});
      if (lowest_m > (1.0 + kMargin) * world.spheres[i].radius_m) continue;
      Contact& contact = add_contact(contacts_, world, i);
      contact.material = collision::pair_material(material_of(world, world.spheres[i].material),
                                                  material_of(world, plane.material));
      contact.is_plane = true;
      contact.other = static_cast<int>(&plane - world.planes.data());
      contact.plane_normal = plane.normal;
      contact.plane_offset_m = plane.offset_m;
      contact.depth_before_m = contact.radius_a_m - height_m;
    }
  }
}

void Detection::find_tool_contacts(const bodies::World& world,
                                   const std::vector<ToolSphereMotion>& tool) {
  while (!contacts_.empty() && contacts_.back().is_tool) contacts_.pop_back();
  const collision::GridView view = moving_.grid().view();
  for (const ToolSphereMotion& b : tool) {
    const collision::SweptBound path =
        collision::bound_sweep(b.position_before_m, b.position_m, b.radius_m);
    collision::for_each_candidate(view, path, collision::kAllVisits, [&](std::uint32_t i) {
      if (!is_free(i) || !collision::meet(paths_[i], path)) return;
      Contact& contact = add_contact(contacts_, world, i);
      contact.material = collision::tool_material(material_of(world, world.spheres[i].material),
                                                  world.tool_slip_speed_m_s);
      contact.radius_b_m = b.radius_m;
      contact.position_b_m = b.position_m;
      contact.start_b_m = b.position_before_m;
      contact.velocity_b_m_s = b.velocity_m_s;
      contact.spin_b_rad_s = b.spin_rad_s;
      contact.is_tool = true;
      contact.other = static_cast<int>(&b - tool.data());
      contact.depth_before_m =
          contact.radius_a_m + b.radius_m - (motion_[i].position_m - b.position_before_m).norm();
    });
  }
}

}  // namespace stillgrid::contact
