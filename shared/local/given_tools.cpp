#include "shared/local/given_tools.hpp"

#include <algorithm>
#include <utility>

#include "shared/collision/proxy_load.hpp"
#include "shared/dynamics/engine.hpp"
#include "shared/dynamics/rigid_motion.hpp"

namespace stillgrid::local {
namespace {

using dynamics::kTick_s;
using Eigen::Matrix3d, Eigen::Vector3d;

}  // namespace

GivenTools::GivenTools(const GivenModel& model) : model_(model), tools_(model.tools.size()) {
  std::size_t count = 0;
  for (std::size_t hand = 0; hand < tools_.size(); ++hand) {
    tools_[hand].first = count;
    count += model.tools[hand].spheres.size();
  }
  proxies_.resize(count);
  contacts_.reserve(kMaxContacts);
  near_.reserve(kMaxGivenSpheres);
  spaces_.reserve(kMaxGivenSpheres);
  seen_.reserve(kMaxGivenSpheres);
}

void GivenTools::begin(const GivenState& state) noexcept {
  for (Tool& tool : tools_) tool.is_here = false;
  for (GivenProxy& proxy : proxies_) proxy.is_here = false;
  if (state.proxies.size() != proxies_.size()) return;
  std::ranges::copy(state.proxies, proxies_.begin());
}

void GivenTools::place(std::span<const std::optional<dynamics::ToolPose>> poses) noexcept {
  for (std::size_t hand = 0; hand < tools_.size(); ++hand) {
    Tool& tool = tools_[hand];
    const std::span<const GivenModel::ToolSphere> spheres = model_.tools[hand].spheres;
    const auto proxies = std::span(proxies_).subspan(tool.first, spheres.size());
    const bool was_here = std::exchange(tool.is_here, hand < poses.size() && poses[hand]);
    if (!tool.is_here) {
      for (GivenProxy& proxy : proxies) proxy = {};
      continue;
    }
    const Eigen::Quaterniond before = tool.pose.orientation;
    tool.pose = *poses[hand];
    tool.turning_rad_s.setZero();
    if (was_here)
      tool.turning_rad_s =
          dynamics::rotation_vector(tool.pose.orientation * before.conjugate()) / kTick_s;
    for (std::size_t i = 0; i < spheres.size(); ++i) {
      GivenProxy& proxy = proxies[i];
      proxy.from_m = proxy.device_m;
      proxy.device_m = tool.pose.position_m + tool.pose.orientation * spheres[i].centre_m;
      if (std::exchange(proxy.is_here, true)) continue;
      proxy.position_m = proxy.from_m = proxy.device_m;
      proxy.stretch_m.setZero();
      proxy.is_let_out = true;
    }
  }
}

/// The spheres that a proxy may meet in this tick.
void GivenTools::find_near(std::size_t hand, std::size_t i, std::span<const GivenBody> bodies,
                           std::span<const GivenSphere> spheres,
                           std::span<const LedSphere> led) noexcept {
  const GivenProxy& proxy = proxies_[tools_[hand].first + i];
  const double radius_m = model_.tools[hand].spheres[i].radius_m;
  const double way_m = (proxy.device_m - proxy.from_m).norm();
  const double goes_m = way_m + collision::kLayings * collision::longest_move_m(
                                                          radius_m, way_m / collision::kLayings);
  near_.clear();
  for (std::size_t k = 0; k < spheres.size(); ++k) {
    const GivenSphere& sphere = spheres[k];
    const Vector3d line_m = proxy.position_m - led[k].end_m;
    const double within_m = radius_m + sphere.radius_m + goes_m + 2.0 * led[k].moved_m.norm() +
                            collision::SmoothCover::neighbour_gap_m(radius_m, sphere.radius_m);
    // Written so that a NaN does not pass.
    if (!(line_m.squaredNorm() < within_m * within_m)) continue;
    const GivenBody& body = bodies[sphere.body];
    const Vector3d arm_m =
        led[k].end_m + sphere.radius_m * line_m.stableNormalized() - body.centre_m;
    near_.push_back({k, body.twist.head<3>() + body.twist.tail<3>().cross(arm_m) + sphere.own_m_s});
  }
  spaces_.resize(near_.size());
  seen_.resize(near_.size());
}

/// Surfaces are seen as at the end of the tick.
std::span<collision::HalfSpace> GivenTools::lay(const Vector3d& proxy_m, double radius_m,
                                                std::span<const GivenSphere> spheres,
                                                std::span<const LedSphere> led,
                                                collision::TickPart part) noexcept {
  for (std::size_t k = 0; k < near_.size(); ++k) {
    const GivenSphere& sphere = spheres[near_[k].sphere];
    const Vector3d tick_m = kTick_s * near_[k].velocity_m_s;
    const Vector3d line_m = proxy_m + (1.0 - part.from) * tick_m - led[near_[k].sphere].end_m;
    const double distance_m = line_m.norm();
    spaces_[k] = {
        .normal = distance_m > 1e-12 ? Vector3d(line_m / distance_m) : Vector3d(Vector3d::UnitZ()),
        .gap_m = distance_m - radius_m - sphere.radius_m,
        .moved_m = part.share() * tick_m};
    seen_[k] = {static_cast<int>(sphere.body), sphere.radius_m, line_m};
  }
  cover_.lay(radius_m, seen_, spaces_);
  return spaces_;
}

void GivenTools::follow(std::size_t hand, std::size_t i, std::span<const GivenSphere> spheres,
                        std::span<const LedSphere> led) noexcept {
  GivenProxy& proxy = proxies_[tools_[hand].first + i];
  const double radius_m = model_.tools[hand].spheres[i].radius_m;
  proxy.position_m =
      collision::follow(proxy.position_m, {proxy.from_m, proxy.device_m, radius_m, kTick_s},
                        [&](const Vector3d& proxy_m, collision::TickPart part) {
                          return lay(proxy_m, radius_m, spheres, led, part);
                        });
  proxy.is_let_out =
      proxy.is_let_out && std::ranges::any_of(spaces_, &collision::HalfSpace::lets_out);
  cover_.share(spaces_);
}

/// The contacts of one tool sphere. Friction is the proxy's, shared as the spring's force.
void GivenTools::push(std::size_t hand, std::size_t i, std::span<const GivenSphere> spheres,
                      const Vector3d& moved_m) noexcept {
  const Tool& tool = tools_[hand];
  const std::size_t number = tool.first + i;
  GivenProxy& proxy = proxies_[number];
  const double radius_m = model_.tools[hand].spheres[i].radius_m;
  const std::size_t first = contacts_.size();
  collision::ProxyLoad load;
  for (std::size_t k = 0; k < near_.size() && contacts_.size() < kMaxContacts; ++k) {
    const collision::HalfSpace& space = spaces_[k];
    if (!(space.push_m > 0.0)) continue;
    const GivenSphere& sphere = spheres[near_[k].sphere];
    const collision::ContactMaterial& material = model_.materials[sphere.material];
    const double share = space.push_m / space.depth_m;
    const Vector3d point_m = proxy.device_m - radius_m * space.normal;
    const Vector3d slip_m_s = tool.pose.velocity_m_s +
                              tool.turning_rad_s.cross(point_m - tool.pose.position_m) -
                              near_[k].velocity_m_s;
    const double approach_m_s = -space.normal.dot(slip_m_s);
    const double normal_N =
        share * collision::normal_force_N(material, space.depth_m, approach_m_s);
    const double along_kg = share * kTick_s *
                            (kTick_s * material.stiffness_N_per_m +
                             (approach_m_s > 0.0 ? material.damping_N_s_per_m : 0.0));
    const double press_N = load.add(material, space, 1.0, near_[k].velocity_m_s, slip_m_s);
    contacts_.push_back({hand, number, near_[k].sphere, point_m, -normal_N * space.normal,
                         along_kg * space.normal * space.normal.transpose(), press_N});
  }
  const auto pull = load.pull(proxy.position_m - proxy.device_m, moved_m, kTick_s);
  if (!pull) {
    proxy.stretch_m.setZero();
    return;
  }
  collision::StickingFriction friction{proxy.stretch_m};
  const Vector3d friction_N = friction.force_N(*pull);
  proxy.stretch_m = friction.stretch_m;
  const Matrix3d across = Matrix3d::Identity() - pull->normal * pull->normal.transpose();
  // What slides is slowed by its limit at most.
  const double slides_m_s = (across * pull->velocity_m_s).norm();
  const double across_kg =
      std::min(kTick_s * (kTick_s * pull->stiffness_N_per_m + pull->damping_N_s_per_m),
               kTick_s * pull->limit_N / std::max(slides_m_s, 1e-9));
  for (GivenContact& contact : std::span(contacts_).subspan(first)) {
    const double share = contact.press_N / load.weight_N;
    contact.force_N -= share * friction_N;
    contact.resisting_kg += share * across_kg * across;
  }
}

std::span<const GivenContact> GivenTools::touch(std::span<const GivenBody> bodies,
                                                std::span<const GivenSphere> spheres,
                                                std::span<const LedSphere> led) noexcept {
  contacts_.clear();
  for (std::size_t hand = 0; hand < tools_.size(); ++hand) {
    if (!tools_[hand].is_here) continue;
    for (std::size_t i = 0; i < model_.tools[hand].spheres.size(); ++i) {
      const GivenProxy& proxy = proxies_[tools_[hand].first + i];
      find_near(hand, i, bodies, spheres, led);
      follow(hand, i, spheres, led);
      push(hand, i, spheres, proxy.device_m - proxy.from_m);
    }
  }
  return contacts_;
}

void GivenTools::settle(std::span<const GivenBody> bodies, std::span<const GivenSphere> spheres,
                        std::span<const Pushed> pushed) noexcept {
  for (GivenProxy& proxy : proxies_) proxy.carrier = GivenProxy::kNone;
  for (std::size_t c = 0; c < contacts_.size();) {
    const std::size_t first = c;
    Vector3d aside_m = Vector3d::Zero();
    double weight_N = 0.0;
    for (; c < contacts_.size() && contacts_[c].proxy == contacts_[first].proxy; ++c) {
      aside_m += contacts_[c].press_N * pushed[c].aside_m;
      weight_N += contacts_[c].press_N;
    }
    aside_m /= weight_N;
    GivenProxy& proxy = proxies_[contacts_[first].proxy];
    const Vector3d normal = (proxy.position_m - proxy.device_m).stableNormalized();
    proxy.position_m += aside_m;
    proxy.stretch_m -= aside_m - normal.dot(aside_m) * normal;
    const auto all = std::span(contacts_).subspan(first, c - first);
    const auto most = std::ranges::max_element(all, {}, &GivenContact::press_N) - all.begin();
    const std::size_t carries = first + static_cast<std::size_t>(most);
    const GivenSphere& carrier = spheres[contacts_[carries].sphere];
    proxy.carrier = carrier.number;
    proxy.carrier_body = bodies[carrier.body].number;
    proxy.arm_m = proxy.position_m - pushed[carries].end_m;
  }
}

double GivenTools::behind_m(std::size_t hand) const noexcept {
  const Tool& tool = tools_[hand];
  double longest_m = 0.0;
  for (std::size_t i = 0; i < model_.tools[hand].spheres.size(); ++i) {
    const GivenProxy& proxy = proxies_[tool.first + i];
    if (proxy.is_here) longest_m = std::max(longest_m, (proxy.position_m - proxy.device_m).norm());
  }
  return longest_m;
}

}  // namespace stillgrid::local
