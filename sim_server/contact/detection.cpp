#include "sim_server/contact/detection.hpp"

#include <algorithm>

#include "shared/collision/grid_query.hpp"

namespace stillgrid {
namespace {

/// Slack round a sphere's predicted path, of its radius: what a push within the step may add.
constexpr float kMargin = 0.1F;
constexpr float kVoxelWithoutSpheres_m = 0.01F;

template <class Spheres>
float voxel_for(const Spheres& spheres, double voxel_ratio) {
  if (spheres.empty()) return kVoxelWithoutSpheres_m;
  double sum_m = 0.0;
  for (const auto& sphere : spheres) sum_m += 2.0 * sphere.radius_m;
  return static_cast<float>(voxel_ratio * sum_m / static_cast<double>(spheres.size()));
}

proto::SphereImage image_of(const Eigen::Vector3d& position_m) {
  const Eigen::Vector3f p = position_m.cast<float>();
  return {{p.x(), p.y(), p.z()}, {0.0F, 0.0F, 0.0F}};
}

bool is_free(const World& world, const SphereBinding& sphere) {
  return sphere.rigid < 0 ||
         world.rigid_bodies[static_cast<std::size_t>(sphere.rigid)].unknown != kNoUnknown;
}

}  // namespace

bool may_collide(const SphereBinding& a, const SphereBinding& b) {
  if (a.body != b.body) return true;
  if (a.rigid >= 0) return false;
  const double near_m = 2.0 * (a.radius_m + b.radius_m);
  return (a.rest_position_m - b.rest_position_m).squaredNorm() > near_m * near_m;
}

std::vector<proto::SphereRecord> still_records(const World& world) {
  std::vector<proto::SphereRecord> records;
  for (const StillSphere& sphere : world.still_spheres) {
    proto::SphereRecord& record = records.emplace_back();
    const proto::SphereImage image = image_of(sphere.position_m);
    record.newest = {image, image};
    record.older = {image, image};
    record.radius_m = static_cast<float>(sphere.radius_m);
    record.material = static_cast<std::uint32_t>(sphere.material);
    record.body = static_cast<std::uint32_t>(sphere.body);
  }
  return records;
}

Detection::Detection(const World& world, double voxel_ratio)
    : voxel_m_(voxel_for(world.spheres, voxel_ratio)),
      still_voxel_m_(voxel_for(world.still_spheres, voxel_ratio)),
      moving_(0, world.spheres.size()),
      still_(0, world.still_spheres.size()),
      motion_(world.spheres.size()) {
  const auto records = still_records(world);
  std::copy(records.begin(), records.end(), still_.records().begin());
  still_.fill(records.size(), still_voxel_m_);
  for (std::size_t i = 0; i < world.spheres.size(); ++i)
    moving_.records()[i].radius_m =
        static_cast<float>(world.spheres[i].radius_m) * (1.0F + kMargin);
}

void Detection::find_contacts(const World& world, double step_s) {
  contacts_.clear();
  enter_spheres(world, step_s);
  add_pairs(world);
  add_still(world);
  add_planes(world);
}

void Detection::enter_spheres(const World& world, double step_s) {
  const auto records = moving_.records();
  for (std::size_t i = 0; i < world.spheres.size(); ++i) {
    motion_[i] = sphere_motion(world, world.spheres[i]);
    // Where it is, where it would be without and with its fall: every shorter step ends between
    // them.
    const Eigen::Vector3d straight_m = motion_[i].position_m + step_s * motion_[i].velocity_m_s;
    const proto::SphereImage now = image_of(motion_[i].position_m);
    records[i].newest = {now, image_of(straight_m + step_s * step_s * world.gravity_m_s2)};
    records[i].older = {now, image_of(straight_m)};
  }
  moving_.fill(world.spheres.size(), voxel_m_);
}

void Detection::add_pairs(const World& world) {
  const auto records = moving_.records();
  for_each_pair(moving_.view(), [&](std::uint32_t i, std::uint32_t j) {
    const SphereBinding &a = world.spheres[i], &b = world.spheres[j];
    if (!may_collide(a, b) || (!is_free(world, a) && !is_free(world, b))) return;
    const Box box_a = swept_box(records[i]), box_b = swept_box(records[j]);
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (box_a.low_m[axis] > box_b.high_m[axis] || box_b.low_m[axis] > box_a.high_m[axis]) return;
    const double distance_m = (motion_[i].position_m - motion_[j].position_m).norm();
    Contact& contact = contacts_.emplace_back();
    contact.a = static_cast<int>(i);
    contact.b = static_cast<int>(j);
    contact.material = pair_material(world.materials[static_cast<std::size_t>(a.material)],
                                     world.materials[static_cast<std::size_t>(b.material)]);
    contact.radius_a_m = a.radius_m;
    contact.radius_b_m = b.radius_m;
    contact.depth_before_m = a.radius_m + b.radius_m - distance_m;
  });
}

void Detection::add_still(const World& world) {
  if (world.still_spheres.empty()) return;
  const auto records = moving_.records();
  for (std::size_t i = 0; i < world.spheres.size(); ++i) {
    const SphereBinding& a = world.spheres[i];
    if (!is_free(world, a)) continue;
    for_each_candidate(still_.view(), swept_box(records[i]), kAllVisits,
                       [&](std::uint32_t j, const RecordLine& /*line*/) {
                         const StillSphere& b = world.still_spheres[j];
                         Contact& contact = contacts_.emplace_back();
                         contact.a = static_cast<int>(i);
                         contact.material =
                             pair_material(world.materials[static_cast<std::size_t>(a.material)],
                                           world.materials[static_cast<std::size_t>(b.material)]);
                         contact.radius_a_m = a.radius_m;
                         contact.radius_b_m = b.radius_m;
                         contact.position_b_m = b.position_m;
                         contact.depth_before_m = a.radius_m + b.radius_m -
                                                  (motion_[i].position_m - b.position_m).norm();
                       });
  }
}

void Detection::add_planes(const World& world) {
  const auto records = moving_.records();
  for (const StillPlane& plane : world.planes)
    for (std::size_t i = 0; i < world.spheres.size(); ++i) {
      const SphereBinding& a = world.spheres[i];
      if (!is_free(world, a)) continue;
      const auto height_m = [&](const proto::SphereImage& image) {
        const auto& p = image.position_m;
        return plane.normal.dot(Eigen::Vector3d(p[0], p[1], p[2])) - plane.offset_m;
      };
      const double lowest_m =
          std::min({height_m(records[i].newest[0]), height_m(records[i].newest[1]),
                    height_m(records[i].older[1])});
      if (lowest_m > records[i].radius_m) continue;
      Contact& contact = contacts_.emplace_back();
      contact.a = static_cast<int>(i);
      contact.material = pair_material(world.materials[static_cast<std::size_t>(a.material)],
                                       world.materials[static_cast<std::size_t>(plane.material)]);
      contact.radius_a_m = a.radius_m;
      contact.is_plane = true;
      contact.plane_normal = plane.normal;
      contact.plane_offset_m = plane.offset_m;
      contact.depth_before_m =
          a.radius_m - (plane.normal.dot(motion_[i].position_m) - plane.offset_m);
    }
}

void Detection::find_tool_contacts(const World& world, const std::vector<ToolSphereMotion>& tool) {
  for (const ToolSphereMotion& b : tool)
    for_each_candidate(
        moving_.view(), box_round(b.position_m, b.radius_m), kAllVisits,
        [&](std::uint32_t i, const RecordLine& /*line*/) {
          const SphereBinding& a = world.spheres[i];
          if (!is_free(world, a)) return;
          Contact& contact = contacts_.emplace_back();
          contact.a = static_cast<int>(i);
          contact.material = tool_material(world.materials[static_cast<std::size_t>(a.material)],
                                           world.tool_slip_speed_m_s);
          contact.radius_a_m = a.radius_m;
          contact.radius_b_m = b.radius_m;
          contact.position_b_m = b.position_m;
          contact.velocity_b_m_s = b.velocity_m_s;
          contact.depth_before_m =
              a.radius_m + b.radius_m - (motion_[i].position_m - b.position_before_m).norm();
        });
}

}  // namespace stillgrid
