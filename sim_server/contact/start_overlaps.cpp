#include "sim_server/contact/start_overlaps.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "shared/collision/distance_field.hpp"
#include "shared/collision/grid_query.hpp"
#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/contact/moving_spheres.hpp"
#include "sim_server/contact/self_collision.hpp"

namespace stillgrid::contact {
namespace {

constexpr double kDeep = 0.5;  // of the smaller radius
constexpr float kStaticRatio = 1.5F;

class OverlapSearch {
 public:
  explicit OverlapSearch(const bodies::World& world)
      : world_(world),
        self_collision_(world),
        spheres_(world.spheres.size(), 0.0F, groups()),
        static_(0, world.static_spheres.size()) {
    for (const bodies::SphereBinding& sphere : world.spheres) {
      position_m_.push_back(bodies::sphere_motion(world, sphere).position_m);
      balls_.push_back(collision::bound_sphere(position_m_.back(), sphere.radius_m));
    }
    std::vector<collision::SweptBound> bounds;
    for (const bodies::StaticSphere& sphere : world.static_spheres)
      bounds.push_back(collision::bound_sphere(sphere.position_m, sphere.radius_m));
    static_.enter(bounds, kStaticRatio);
  }

  std::vector<Overlap> found() && {
    add_pairs();
    for (std::uint32_t i = 0; i < balls_.size(); ++i) {
      if (!is_free(i)) continue;
      if (!world_.spheres[i].is_field_point) add_static(i);
      add_planes(i);
    }
    for (const bodies::FieldBody& field : world_.fields) add_field(field);
    return std::move(overlaps_);
  }

 private:
  [[nodiscard]] bool is_free(std::size_t i) const {
    const int rigid = world_.spheres[i].rigid;
    return rigid < 0 || world_.rigid_bodies[static_cast<std::size_t>(rigid)].free;
  }
  [[nodiscard]] bool is_free(const bodies::FieldBody& field) const {
    return field.rigid >= 0 && world_.rigid_bodies[static_cast<std::size_t>(field.rigid)].free;
  }

  /// Spheres of a rigid body never touch each other, nor do those of all that is prescribed, nor
  /// points of fields.
  [[nodiscard]] std::vector<std::uint32_t> groups() const {
    constexpr std::uint32_t kPrescribed = 0xffff'fffe, kPoints = 0xffff'fffd;
    std::vector<std::uint32_t> groups;
    for (std::size_t i = 0; i < world_.spheres.size(); ++i) {
      const bodies::SphereBinding& sphere = world_.spheres[i];
      const auto own = sphere.rigid < 0 ? kNoGroup : static_cast<std::uint32_t>(sphere.rigid);
      groups.push_back(sphere.is_field_point ? kPoints : is_free(i) ? own : kPrescribed);
    }
    return groups;
  }

  void add(const Overlap& overlap, double smaller_m) {
    if (overlap.depth_m > kDeep * smaller_m) overlaps_.push_back(overlap);
  }

  void add_pairs() {
    const std::vector<bodies::SphereBinding>& all = world_.spheres;
    const auto may_collide = [&](std::uint32_t i, std::uint32_t j) {
      return (is_free(i) || is_free(j)) && !all[i].is_field_point && !all[j].is_field_point &&
             bodies::may_collide(world_, all[i].body, all[j].body) &&
             self_collision_.may_collide(all[i], all[j]);
    };
    for (const auto& [i, j] : spheres_.find(balls_, may_collide))
      add({all[i].body, all[j].body, true, -1,
           all[i].radius_m + all[j].radius_m - (position_m_[i] - position_m_[j]).norm()},
          std::min(all[i].radius_m, all[j].radius_m));
  }

  void add_static(std::uint32_t i) {
    const bodies::SphereBinding& own = world_.spheres[i];
    collision::for_each_candidate(
        static_.view(), balls_[i], collision::kAllVisits, [&](std::uint32_t j) {
          const bodies::StaticSphere& other = world_.static_spheres[j];
          if (!bodies::may_collide(world_, own.body, other.body)) return;
          add({own.body, other.body, false, -1,
               own.radius_m + other.radius_m - (position_m_[i] - other.position_m).norm()},
              std::min(own.radius_m, other.radius_m));
        });
  }

  void add_planes(std::uint32_t i) {
    const bodies::SphereBinding& own = world_.spheres[i];
    for (std::size_t k = 0; k < world_.planes.size(); ++k) {
      const bodies::StaticPlane& plane = world_.planes[k];
      if (!bodies::may_collide(world_, own.body, plane.body)) continue;
      add({own.body, plane.body, false, static_cast<int>(k),
           own.radius_m - (plane.normal.dot(position_m_[i]) - plane.offset_m)},
          2.0 * own.radius_m);
    }
  }

  /// Fields are few: each is held against all spheres near the ball that holds it.
  void add_field(const bodies::FieldBody& field) {
    Eigen::Vector3d origin_m = field.position_m;
    Eigen::Quaterniond turn = field.orientation;
    if (field.rigid >= 0) {
      const bodies::RigidBody& body = world_.rigid_bodies[static_cast<std::size_t>(field.rigid)];
      origin_m = body.position_m + body.orientation * field.position_m;
      turn = body.orientation * field.orientation;
    }
    const proto::FieldShape& shape = field.field->shape();
    const double bounding_radius_m = double{shape.bounding_radius_m};
    const collision::SweptBound ball = collision::bound_sphere(
        origin_m + turn * Eigen::Map<const Eigen::Vector3f>(shape.centre_m.data()).cast<double>(),
        bounding_radius_m);
    const auto depth_m = [&](const Eigen::Vector3d& centre_m, double radius_m) {
      const auto contact = collision::field_contact(
          field.field->view(), turn.conjugate() * (centre_m - origin_m), radius_m);
      return contact ? contact->depth_m : 0.0;
    };
    for (std::size_t i = 0; i < balls_.size(); ++i) {
      const bodies::SphereBinding& sphere = world_.spheres[i];
      if (!collision::meet(ball, balls_[i]) || sphere.body == field.body ||
          !(is_free(i) || is_free(field)) || !bodies::may_collide(world_, sphere.body, field.body))
        continue;
      // The radius of a point does not depend on the size of its body.
      const double small_m = sphere.is_field_point ? collision::detail_m(shape) : sphere.radius_m;
      add({sphere.body, field.body, true, -1, depth_m(position_m_[i], sphere.radius_m)},
          std::min(small_m, bounding_radius_m));
    }
    if (!is_free(field)) return;
    for (const bodies::StaticSphere& sphere : world_.static_spheres)
      if (bodies::may_collide(world_, field.body, sphere.body) &&
          collision::meet(ball, collision::bound_sphere(sphere.position_m, sphere.radius_m)))
        add({field.body, sphere.body, false, -1, depth_m(sphere.position_m, sphere.radius_m)},
            std::min(sphere.radius_m, bounding_radius_m));
  }

  const bodies::World& world_;
  SelfCollision self_collision_;
  MovingSpheres spheres_;
  collision::VoxelGrid static_;
  std::vector<Eigen::Vector3d> position_m_;  // of moving spheres
  std::vector<collision::SweptBound> balls_;
  std::vector<Overlap> overlaps_;
};

}  // namespace

std::vector<Overlap> deep_overlaps(const bodies::World& world) {
  if (world.spheres.empty()) return {};
  return OverlapSearch(world).found();
}

}  // namespace stillgrid::contact
