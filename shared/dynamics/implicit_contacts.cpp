#include "shared/dynamics/implicit_contacts.hpp"

#include <algorithm>

#include "shared/dynamics/at.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr double kShortest_m = 1e-12;  // lines of centres below it have no direction

void set_body(const Description::Sphere& sphere, ActedPoint& point) {
  point.rigid = sphere.rigid;
  point.node_count = sphere.rigid >= 0 ? 0 : sphere.node_count;
  point.nodes = sphere.nodes;
  point.weights = sphere.weights;
}

}  // namespace

ImplicitContacts::ImplicitContacts(const Description& description)
    : description_(description),
      before_m_(description.spheres.size()),
      after_m_(description.spheres.size()),
      field_before_(description.fields.size()),
      field_after_(description.fields.size()) {}

void ImplicitContacts::leave_out(std::span<const std::uint8_t> sleeping_spheres) {
  awake_.clear();
  for (std::size_t s = 0; s < sleeping_spheres.size(); ++s)
    if (sleeping_spheres[s] == 0 && !description_.is_fixture(description_.spheres[s].rigid))
      awake_.push_back(s);
}

void ImplicitContacts::add_lane(const ContactListing& listing, const RowGroup& group,
                                std::size_t row, std::size_t lane) {
  const RowPlace& place = listing.rows().places[row];
  const ContactRow& contact = listing.rows().rows[row];
  const bool is_plane = group.b == SideKind::kPlane;
  Touch touch;
  touch.row = static_cast<std::uint32_t>(row);
  touch.lane = static_cast<std::uint32_t>(lane);
  touch.sphere_a = listing.order()[at(place.sphere_a[lane])];
  const bool is_field = !is_plane && listing.is_field(place.sphere_b[lane]);
  touch.sphere_b = is_plane || is_field ? -1 : listing.order()[at(place.sphere_b[lane])];
  touch.radius_a_m = description_.spheres[at(touch.sphere_a)].radius_m;
  Coupling coupling;
  set_body(description_.spheres[at(touch.sphere_a)], coupling.a);
  if (is_plane) {
    const Description::Plane& plane = description_.planes[at(place.sphere_b[lane])];
    touch.normal = plane.normal;
    touch.offset_m = plane.offset_m;
  } else if (!is_field) {
    touch.radius_b_m = description_.spheres[at(touch.sphere_b)].radius_m;
    set_body(description_.spheres[at(touch.sphere_b)], coupling.b);
  }
  touch.stiffness_N_per_m = static_cast<double>(place.stiffness_N_per_m[lane]);
  touch.damping_N_s_per_m = static_cast<double>(place.damping_N_s_per_m[lane]);
  if (is_field) set_field(listing, place.sphere_b[lane], touch, coupling);
  if (const ToolLane* const tool = listing.tool_lane(row, lane)) set_tool(*tool, touch);
  touch.friction = static_cast<double>(contact.friction[lane]);
  touch.viscous_s_per_m = static_cast<double>(contact.viscous_s_per_m[lane]);
  for (std::size_t k = 0; k < 3; ++k)
    touch.stretch_m[static_cast<Eigen::Index>(k)] = static_cast<double>(place.stretch_m[k][lane]);
  touches_.push_back(touch);
  couplings_.push_back(coupling);
}

void ImplicitContacts::set_tool(const ToolLane& tool, Touch& touch) {
  touch.shift_m = (tool.is_a ? 1.0 : -1.0) * tool.shift_m;
  touch.is_held = tool.is_held;
  touch.held_centre_m = tool.centre_m;
  touch.held_scale = tool.share * tool.map_scale;
}

void ImplicitContacts::start(const ImplicitPoses& poses, const ContactListing& listing) {
  for (std::size_t s = 0; s < before_m_.size(); ++s)
    before_m_[s] = after_m_[s] = poses.before_m(description_.spheres[s]);
  for (std::size_t f = 0; f < field_before_.size(); ++f)
    field_before_[f] = field_pose(description_.fields[f], poses.from());
  touches_.clear();
  couplings_.clear();
  const auto world =
      static_cast<std::int32_t>(description_.nodes.size() + description_.rigid_bodies.size());
  for (const RowGroup& group : listing.rows().groups)
    for (std::size_t row = group.first; row < group.end; ++row)
      for (std::size_t lane = 0; lane < kRowLanes; ++lane)
        if (listing.rows().rows[row].mover_a[lane] != world) add_lane(listing, group, row, lane);
  for (Touch& touch : touches_) touch.line_m = start_line_m(touch);
}

void ImplicitContacts::move(const ImplicitPoses& poses) {
  for (const std::size_t s : awake_) after_m_[s] = poses.after_m(description_.spheres[s]);
  for (std::size_t f = 0; f < field_after_.size(); ++f)
    field_after_[f] = field_pose(description_.fields[f], poses.to());
}

/// The direction times the change of the distance is the change of the line along it.
ImplicitContacts::Line ImplicitContacts::line_of(const Touch& touch) const {
  const Eigen::Vector3d& a = after_m_[at(touch.sphere_a)];
  Line line;
  if (touch.field < 0 && touch.sphere_b < 0) {
    line.after_m = touch.normal.dot(a) - touch.offset_m;
    line.before_m = touch.normal.dot(touch.line_m);
    line.line_m = line.after_m * touch.normal;
    line.direction = line.normal = touch.normal;
    return line;
  }
  if (touch.is_held) {
    line.line_m = a - field_after_[at(touch.field)].out_of(touch.held_centre_m);
    line.scale = touch.held_scale;
  } else if (touch.field >= 0) {
    const auto f = at(touch.field);
    const TangentSphere tangent =
        tangent_sphere(description_.fields[f], field_after_[f], a, touch.radius_a_m);
    line.line_m = tangent_line_m(tangent, touch.radius_a_m + touch.radius_b_m);
    line.scale = tangent.stiffness_scale;
    line.stiffness_root = stiffness_root(tangent);
  } else {
    line.line_m = a - after_m_[at(touch.sphere_b)] + touch.shift_m;
  }
  line.after_m = line.line_m.norm();
  line.before_m = touch.line_m.norm();
  line.direction =
      (line.line_m + touch.line_m) / std::max(line.after_m + line.before_m, kShortest_m);
  line.normal = line.direction.stableNormalized();
  return line;
}

void ImplicitContacts::evaluate(const ImplicitPoses& poses, const Motions& velocities) {
  move(poses);
  for (std::size_t k = 0; k < touches_.size(); ++k)
    evaluate(touches_[k], couplings_[k], poses, velocities);
}

void ImplicitContacts::evaluate(Touch& touch, Coupling& coupling, const ImplicitPoses& poses,
                                const Motions& velocities) const {
  const double h = poses.step_s(), radii = touch.radius_a_m + touch.radius_b_m;
  const Line line = line_of(touch);
  const double depth_m = radii - line.after_m;
  coupling.is_active = depth_m > 0.0 || touch.limit_impulse_N_s > 0.0;
  coupling.impulse_N_s.setZero();
  coupling.slope_kg.setZero();
  touch.push_impulse_N_s = 0.0;
  touch.friction_impulse_N_s.setZero();
  touch.stretch_after_m.setZero();
  touch.scale = line.scale;
  touch.stiffness_root = line.stiffness_root;
  if (!coupling.is_active) return;
  const double k = touch.scale * touch.stiffness_N_per_m;
  const double c = touch.scale * touch.damping_N_s_per_m;
  const double deepens_m = depth_m - std::max(0.0, radii - line.before_m);
  touch.push_impulse_N_s = h * k * depth_m + c * std::max(0.0, deepens_m);
  coupling.impulse_N_s = touch.push_impulse_N_s * line.direction;
  coupling.slope_kg =
      (h * h * k + (deepens_m > 0.0 ? h * c : 0.0)) * line.direction * line.direction.transpose();
  set_arms(touch, coupling, line, poses, Moment::kMean);
  if (touch.limit_impulse_N_s > 0.0)
    rub(touch, coupling, line.normal, relative_velocity(coupling, velocities, poses), h);
}

/// From the centres of rigid bodies to the point of contact.
void ImplicitContacts::set_arms(const Touch& touch, Coupling& coupling, const Line& line,
                                const ImplicitPoses& poses, Moment moment) const {
  const bool is_mean = moment == Moment::kMean;
  const double distance_m = is_mean ? 0.5 * (line.before_m + line.after_m) : line.after_m;
  const double lever = distance_m / (touch.radius_a_m + touch.radius_b_m);
  const auto set_arm = [&](ActedPoint& point, std::int32_t sphere, double out_m) {
    if (point.rigid < 0) return;
    const auto r = at(point.rigid);
    const Eigen::Vector3d& local_m = description_.spheres[at(sphere)].local_m;
    point.arm_m =
        (is_mean ? poses.mean_arm_m(r, local_m) : poses.arm_m(r, local_m)) + out_m * line.normal;
  };
  set_arm(coupling.a, touch.sphere_a, -lever * touch.radius_a_m);
  if (touch.field >= 0) {
    coupling.b.arm_m = field_arm_m(touch, poses, moment) - lever * touch.radius_a_m * line.normal;
  } else {
    set_arm(coupling.b, touch.sphere_b, lever * touch.radius_b_m);
  }
}

void ImplicitContacts::write(RowList& rows) const {
  for (const Touch& touch : touches_) {
    ContactRow& row = rows.rows[touch.row];
    RowPlace& place = rows.places[touch.row];
    row.push_impulse_N_s[touch.lane] = static_cast<float>(touch.push_impulse_N_s);
    const Eigen::Vector3d direction = line_of(touch).direction;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      row.normal[k][touch.lane] = static_cast<float>(direction[axis]);
      row.friction_impulse_N_s[k][touch.lane] =
          static_cast<float>(touch.friction_impulse_N_s[axis] + 0.0);
      place.stretch_m[k][touch.lane] =
          static_cast<float>(touch.stiffness_root * touch.stretch_after_m[axis]);
    }
  }
}

void ImplicitContacts::write_places(const ContactListing& listing,
                                    std::vector<SpherePlace>& places) const {
  for (std::size_t k = 0; k < listing.order().size(); ++k)
    set_vector(places[k].moved_m, Vector4(after_m_[at(listing.order()[k])]) - listing.base()[k]);
  for (const Touch& touch : touches_) {
    if (touch.field < 0) continue;
    const RowPlace& row = listing.rows().places[touch.row];
    const auto k = at(row.sphere_a[touch.lane]);
    set_vector(places[at(row.sphere_b[touch.lane])].moved_m,
               Vector4(after_m_[at(touch.sphere_a)] - line_of(touch).line_m) - listing.base()[k]);
  }
}

}  // namespace stillgrid::dynamics
