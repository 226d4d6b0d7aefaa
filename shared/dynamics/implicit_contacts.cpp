#include "shared/dynamics/implicit_contacts.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid::dynamics {
namespace {

constexpr double kShortest_m = 1e-12;  // lines of centres below it have no direction

std::size_t at(std::int32_t index) {
  return static_cast<std::size_t>(index);
}

void set_body(const Description::Sphere& sphere, ActedPoint& point) {
  point.rigid = sphere.rigid;
  point.node_count = sphere.rigid >= 0 ? 0 : sphere.node_count;
  point.nodes = sphere.nodes;
  point.weights = sphere.weights;
}

Eigen::Vector3d across(const Eigen::Vector3d& v, const Eigen::Vector3d& normal) {
  return v - v.dot(normal) * normal;
}

}  // namespace

ImplicitContacts::ImplicitContacts(const Description& description)
    : description_(description),
      before_m_(description.spheres.size()),
      after_m_(description.spheres.size()) {}

void ImplicitContacts::add_lane(const ContactListing& listing, const RowGroup& group,
                                std::size_t row, std::size_t lane) {
  const RowPlace& place = listing.rows().places[row];
  const ContactRow& contact = listing.rows().rows[row];
  const bool is_plane = group.b == SideKind::kPlane;
  Touch touch;
  touch.row = static_cast<std::uint32_t>(row);
  touch.lane = static_cast<std::uint32_t>(lane);
  touch.sphere_a = listing.order()[at(place.sphere_a[lane])];
  touch.sphere_b = is_plane ? -1 : listing.order()[at(place.sphere_b[lane])];
  touch.radius_a_m = description_.spheres[at(touch.sphere_a)].radius_m;
  Coupling coupling;
  set_body(description_.spheres[at(touch.sphere_a)], coupling.a);
  if (is_plane) {
    const Description::Plane& plane = description_.planes[at(place.sphere_b[lane])];
    touch.normal = plane.normal;
    touch.offset_m = plane.offset_m;
  } else {
    touch.radius_b_m = description_.spheres[at(touch.sphere_b)].radius_m;
    set_body(description_.spheres[at(touch.sphere_b)], coupling.b);
  }
  touch.stiffness_N_per_m = static_cast<double>(place.stiffness_N_per_m[lane]);
  touch.damping_N_s_per_m = static_cast<double>(place.damping_N_s_per_m[lane]);
  touch.friction = static_cast<double>(contact.friction[lane]);
  touch.viscous_s_per_m = static_cast<double>(contact.viscous_s_per_m[lane]);
  for (std::size_t k = 0; k < 3; ++k)
    touch.stretch_m[static_cast<Eigen::Index>(k)] = static_cast<double>(place.stretch_m[k][lane]);
  touches_.push_back(touch);
  couplings_.push_back(coupling);
}

void ImplicitContacts::start(const ImplicitPoses& poses, const ContactListing& listing) {
  for (std::size_t s = 0; s < before_m_.size(); ++s)
    before_m_[s] = poses.before_m(description_.spheres[s]);
  touches_.clear();
  couplings_.clear();
  const auto world =
      static_cast<std::int32_t>(description_.nodes.size() + description_.rigid_bodies.size());
  for (const RowGroup& group : listing.rows().groups)
    for (std::size_t row = group.first; row < group.end; ++row)
      for (std::size_t lane = 0; lane < kRowLanes; ++lane)
        if (listing.rows().rows[row].mover_a[lane] != world &&
            !(group.b != SideKind::kPlane &&
              listing.is_field(listing.rows().places[row].sphere_b[lane])))
          add_lane(listing, group, row, lane);
  for (Touch& touch : touches_) {
    const Eigen::Vector3d& a = before_m_[at(touch.sphere_a)];
    if (touch.sphere_b < 0)
      touch.line_m = (touch.normal.dot(a) - touch.offset_m) * touch.normal;
    else
      touch.line_m = a - before_m_[at(touch.sphere_b)];
    // Friction's spring turns with the normal, and keeps its length.
    const double length = touch.stretch_m.norm();
    const Eigen::Vector3d turned = across(touch.stretch_m, touch.line_m.stableNormalized());
    const double is = turned.norm();
    touch.stretch_m = is > kShortest_m ? Eigen::Vector3d(std::min(2.0, length / is) * turned)
                                       : Eigen::Vector3d(Eigen::Vector3d::Zero());
  }
}

/// The direction times the change of the distance is the change of the line along it.
ImplicitContacts::Line ImplicitContacts::line_of(const Touch& touch) const {
  const Eigen::Vector3d& a = after_m_[at(touch.sphere_a)];
  Line line;
  if (touch.sphere_b < 0) {
    line.after_m = touch.normal.dot(a) - touch.offset_m;
    line.before_m = touch.normal.dot(touch.line_m);
    line.line_m = line.after_m * touch.normal;
    line.direction = line.normal = touch.normal;
    return line;
  }
  line.line_m = a - after_m_[at(touch.sphere_b)];
  line.after_m = line.line_m.norm();
  line.before_m = touch.line_m.norm();
  line.direction =
      (line.line_m + touch.line_m) / std::max(line.after_m + line.before_m, kShortest_m);
  line.normal = line.direction.stableNormalized();
  return line;
}

void ImplicitContacts::evaluate(const ImplicitPoses& poses, const Motions& velocities) {
  for (std::size_t s = 0; s < after_m_.size(); ++s)
    after_m_[s] = poses.after_m(description_.spheres[s]);
  for (std::size_t k = 0; k < touches_.size(); ++k)
    evaluate(touches_[k], couplings_[k], poses, velocities);
}

void ImplicitContacts::evaluate(Touch& touch, Coupling& coupling, const ImplicitPoses& poses,
                                const Motions& velocities) const {
  const double h = poses.step_s(), radii = touch.radius_a_m + touch.radius_b_m;
  const Line line = line_of(touch);
  const double depth_m = radii - line.after_m;
  coupling.is_active = depth_m > 0.0 || touch.most_N_s > 0.0;
  coupling.impulse_N_s.setZero();
  coupling.slope_kg.setZero();
  touch.push_N_s = 0.0;
  touch.drag_N_s.setZero();
  touch.stretch_after_m.setZero();
  if (!coupling.is_active) return;
  const double k = touch.stiffness_N_per_m, c = touch.damping_N_s_per_m;
  const double deepens_m = depth_m - std::max(0.0, radii - line.before_m);
  touch.push_N_s = h * k * depth_m + c * std::max(0.0, deepens_m);
  coupling.impulse_N_s = touch.push_N_s * line.direction;
  coupling.slope_kg =
      (h * h * k + (deepens_m > 0.0 ? h * c : 0.0)) * line.direction * line.direction.transpose();
  const double lever = 0.5 * (line.before_m + line.after_m) / radii;
  const auto set_arm = [&](ActedPoint& point, std::int32_t sphere, double out_m) {
    if (point.rigid < 0) return;
    point.arm_m = poses.mean_arm_m(at(point.rigid), description_.spheres[at(sphere)].local_m) +
                  out_m * line.normal;
  };
  set_arm(coupling.a, touch.sphere_a, -lever * touch.radius_a_m);
  set_arm(coupling.b, touch.sphere_b, lever * touch.radius_b_m);
  if (touch.most_N_s > 0.0)
    rub(touch, coupling, line.normal, relative_velocity(coupling, velocities, poses), h);
}

/// Linearises both sides of aim |slip| = slip, where friction is at its limit.
void ImplicitContacts::aim_friction(const ImplicitPoses& poses, const Motions& change) {
  for (std::size_t k = 0; k < touches_.size(); ++k) {
    Touch& touch = touches_[k];
    if (touch.most_N_s == 0.0) continue;
    const Eigen::Vector3d more =
        touch.hold_slope_kg * relative_velocity(couplings_[k], change, poses);
    const double size = std::max(touch.asked_N_s.norm(), touch.most_N_s);
    touch.next_aim = (touch.asked_N_s + more) / size;
    if (size > touch.most_N_s)
      touch.next_aim -= touch.asked_N_s.dot(more) / (size * size) * touch.aim;
  }
}

void ImplicitContacts::turn_aims(double share) {
  for (Touch& touch : touches_) {
    touch.aim += share * (touch.next_aim - touch.aim);
    touch.aim /= std::max(1.0, touch.aim.norm());
  }
}

void ImplicitContacts::limit_friction() {
  for (Touch& touch : touches_) touch.most_N_s = touch.friction * touch.push_N_s;
}

/// Along a slip at Coulomb's limit friction does not grow. The slope has no part along it, once the
/// aim agrees with the slip. An aim of its own keeps Newton's method from jumping between opposite
/// slips [Chan, Golub, Mulet 1999].
void ImplicitContacts::rub(Touch& touch, Coupling& coupling, const Eigen::Vector3d& normal,
                           const Eigen::Vector3d& velocity, double h) const {
  const Eigen::Vector3d slip = across(velocity, normal);
  const double most = touch.most_N_s;
  const bool holds = touch.viscous_s_per_m == 0.0;
  const double k = touch.stiffness_N_per_m, c = touch.damping_N_s_per_m;
  double slope = holds ? h * (h * k + c) : most * touch.viscous_s_per_m;
  const Eigen::Vector3d stretch = across(touch.stretch_m, normal);
  Eigen::Vector3d asked = slope * slip;
  if (holds) asked += h * k * stretch;
  const double size = asked.norm();
  Eigen::Matrix3d plane = Eigen::Matrix3d::Identity() - normal * normal.transpose();
  touch.hold_slope_kg = slope;
  touch.asked_N_s = asked;
  if (size > most) {
    const Eigen::Vector3d along = asked / size, aim = across(touch.aim, normal);
    plane -= 0.5 * (along * aim.transpose() + aim * along.transpose());
    asked *= most / size;
    slope *= most / size;
  }
  touch.drag_N_s = -asked;
  coupling.impulse_N_s -= asked;
  coupling.slope_kg += slope * plane;
  if (holds && k > 0.0) touch.stretch_after_m = (asked + c * stretch) / (h * k + c);
}

bool ImplicitContacts::any_passes() const {
  return std::ranges::any_of(touches_, [&](const Touch& touch) {
    if (touch.sphere_b < 0) return false;  // what is inside a plane is pushed out, however deep
    const Line line = line_of(touch);
    const Eigen::Vector3d way = line.line_m - touch.line_m;
    const double square = way.squaredNorm();
    const double share = -touch.line_m.dot(way);
    if (share <= 0.0 || share >= square) return false;
    const double nearest = (touch.line_m + share / square * way).norm();
    const double radii = touch.radius_a_m + touch.radius_b_m;
    return std::min({radii, line.before_m, line.after_m}) - nearest >
           0.5 * std::min(touch.radius_a_m, touch.radius_b_m);
  });
}

bool ImplicitContacts::all_within(const ContactListing& listing) const {
  for (std::size_t place = 0; place < listing.order().size(); ++place) {
    const std::size_t s = at(listing.order()[place]);
    const Vector4& base = listing.base()[place];
    if ((after_m_[s] - base.vector()).squaredNorm() > base.w * base.w) return false;
  }
  return true;
}

void ImplicitContacts::write(RowList& rows) const {
  for (const Touch& touch : touches_) {
    ContactRow& row = rows.rows[touch.row];
    RowPlace& place = rows.places[touch.row];
    row.push_impulse_N_s[touch.lane] = static_cast<float>(touch.push_N_s);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      row.friction_impulse_N_s[k][touch.lane] = static_cast<float>(touch.drag_N_s[axis] + 0.0);
      place.stretch_m[k][touch.lane] = static_cast<float>(touch.stretch_after_m[axis]);
    }
  }
}

/// Friction takes the work of its force less that of its spring.
void ImplicitContacts::add_losses(const ImplicitPoses& poses, const Motions& velocities,
                                  EnergyLosses& losses) const {
  for (std::size_t k = 0; k < touches_.size(); ++k) {
    const Touch& touch = touches_[k];
    if (!couplings_[k].is_active) continue;
    const Line line = line_of(touch);
    const double radii = touch.radius_a_m + touch.radius_b_m;
    const double deepens_m =
        std::max(0.0, radii - line.after_m) - std::max(0.0, radii - line.before_m);
    if (deepens_m > 0.0)
      losses.contact_damping_J += touch.damping_N_s_per_m / poses.step_s() * deepens_m * deepens_m;
    const Eigen::Vector3d slip = relative_velocity(couplings_[k], velocities, poses);
    const Eigen::Vector3d more = touch.stretch_after_m - across(touch.stretch_m, line.normal);
    losses.friction_J -=
        touch.drag_N_s.dot(slip) + touch.stiffness_N_per_m * touch.stretch_after_m.dot(more);
  }
}

}  // namespace stillgrid::dynamics
