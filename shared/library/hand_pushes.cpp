#include "shared/library/hand_pushes.hpp"

#include <algorithm>

#include "shared/collision/grid_query.hpp"
#include "shared/library/vectors.hpp"
#include "shared/rendering/tool_force.hpp"

namespace stillgrid::library {
namespace {

using Eigen::Vector3d;

/// Of a tool sphere's radius: spheres within it may be touched before the next step.
constexpr double kNear = 4.0;
/// Spheres looked at, and bodies that are pushed: beyond them the rest gives no way, is not pushed.
constexpr std::size_t kMaxNear = 4096, kMaxPushes = 512;

}  // namespace

HandPushes::HandPushes(std::size_t moving_capacity) {
  near_.reserve(kMaxNear);
  chosen_.reserve(proto::kMaxModes);
  responses_.reserve(publication::response_capacity(moving_capacity));
  responding_.reserve(publication::response_capacity(moving_capacity));
  modes_.reserve(proto::kMaxModes);
  turning_.reserve(proto::kMaxTurningBodies);
  pushes_.reserve(kMaxPushes);
  before_.reserve(kMaxPushes);
  sphere_pushes_.reserve(rendering::TouchedSpheres::kCapacity);
}

void HandPushes::end_step() noexcept {
  std::swap(pushes_, before_);
  clear();
}

void HandPushes::clear() noexcept {
  pushes_.clear();
  sphere_pushes_.clear();
  chosen_.clear();
  responses_.clear();
  responding_.clear();
}

/// The spheres near the tool whose bodies give way, the nearest first.
void HandPushes::find_near(std::span<const rendering::PlacedToolSphere> tool,
                           publication::MovingRecords& moving, std::span<BodyModes> bodies) {
  near_.clear();
  if (bodies.empty()) return;
  const collision::GridView grid = moving.grid().view();
  const auto records = moving.records();
  for (const rendering::PlacedToolSphere& probe : tool) {
    const double margin_m = (1.0 + kNear) * probe.radius_m;
    collision::for_each_candidate(
        grid, collision::bound_sphere(probe.position_m, margin_m), collision::kAllVisits,
        [&](std::uint32_t number) {
          const proto::SphereRecord& record = records[number];
          const auto body = std::lower_bound(
              bodies.begin(), bodies.end(), record.body,
              [](const BodyModes& a, std::uint32_t wanted) { return a.body() < wanted; });
          if (body == bodies.end() || body->body() != record.body || near_.size() == kMaxNear)
            return;
          const double distance_m = (vector(record.newest.position_m) - probe.position_m).norm() -
                                    double{record.radius_m} - probe.radius_m;
          near_.push_back({distance_m, number, &*body});
        });
  }
  std::sort(near_.begin(), near_.end(), [](const Near& a, const Near& b) {
    return a.distance_m != b.distance_m ? a.distance_m < b.distance_m : a.sphere < b.sphere;
  });
}

/// Modes for the nearest bodies, as many as a snapshot has room for, and responses for their
/// nearest spheres.
void HandPushes::choose(publication::MovingRecords& moving) {
  chosen_.clear();
  responses_.clear();
  responding_.clear();
  int modes = 0;
  for (const Near& near : near_) {
    if (chosen_of(near.body->body()) != nullptr || near.body->count() == 0) continue;
    if (modes + near.body->count() > static_cast<int>(proto::kMaxModes)) continue;
    chosen_.push_back({near.body, modes});
    modes += near.body->count();
  }
  const auto records = moving.records();
  for (const Near& near : near_) {
    proto::SphereRecord& record = records[near.sphere];
    const Chosen* chosen = chosen_of(record.body);
    if (chosen == nullptr || record.response != 0) continue;
    if (responses_.size() == responses_.capacity()) break;
    proto::SphereResponse& response = responses_.emplace_back();
    response = {};
    for (int mode = 0; mode < chosen->body->count(); ++mode)
      response.modes[static_cast<std::size_t>(chosen->first + mode)] =
          floats(chosen->body->motion_at(mode, vector(record.newest.position_m)));
    responding_.push_back(near.sphere);
    record.response = static_cast<std::uint32_t>(responses_.size());
  }
}

const HandPushes::Chosen* HandPushes::chosen_of(std::uint32_t body) const noexcept {
  const auto found = std::find_if(chosen_.begin(), chosen_.end(), [&](const Chosen& chosen) {
    return chosen.body->body() == body;
  });
  return found == chosen_.end() ? nullptr : &*found;
}

void HandPushes::find(const proto::SceneHeader& scene, const proto::ToolState& tool,
                      publication::MovingRecords& moving, std::span<BodyModes> bodies,
                      double step_s, bool is_tried) {
  const auto& [x, y, z, w] = tool.orientation_xyzw;
  const rendering::ToolPose pose{Vector3d(tool.position_m.data()), Eigen::Quaterniond(w, x, y, z),
                                 Vector3d(tool.velocity_m_s.data())};
  const std::span<const rendering::PlacedToolSphere> placed =
      rendering::place_tool(scene, pose, placed_);
  double radius_m = 0.0;
  for (const auto& sphere : placed) radius_m = std::max(radius_m, sphere.radius_m);
  find_near(placed, moving, bodies);
  choose(moving);
  lead(moving, step_s, is_tried);

  proto::SnapshotHeader header{};
  header.prediction_ns = static_cast<std::uint64_t>(step_s * 1e9);
  for (const Chosen& chosen : chosen_)
    for (int mode = 0; mode < chosen.body->count(); ++mode)
      header.modes[header.mode_count++] = {1.0F, static_cast<float>(held_[chosen.first + mode]),
                                           0.0F, 0.0F, proto::kOneStep};
  header.largest_response = publication::largest_response(responses_, header.mode_count);
  display::SnapshotWeights weights;
  weights.position[0] = 1.0;
  if (!responses_.empty()) {
    weights.prediction_s = step_s;
    weights.step_share = 1.0;
  }
  response_ = {};
  response_.take(header, weights);
  response_.motion.drift_per_s = (led_ - now_) / step_s;
  rendering::CompliantDisplay compliant;
  compliant.motion = response_.motion;
  compliant.slack_m = responses_.empty() ? 0.0 : radius_m;
  collision::GridView grid = moving.grid().view();
  grid.responses = reinterpret_cast<const std::uint64_t*>(responses_.data());
  grid.response_count = static_cast<std::uint32_t>(responses_.size());
  touched_.clear();
  rendering::gather_touched(grid, {weights, weights, compliant}, placed, touched_);
  // A sphere may have flown through the whole tool in a step: the solver's own steps, each a part
  // of this length, must lead that far.
  double through_m = radius_m;
  for (const rendering::TouchedSphere& sphere : touched_.all())
    through_m = std::max(through_m, radius_m + sphere.radius_m);
  (void)solver_.solve(scene, placed, pose, through_m, true, touched_, response_);
  sum_pushes(scene, pose, placed, touched_, moving);
}

void HandPushes::sum_pushes(const proto::SceneHeader& scene, const rendering::ToolPose& pose,
                            std::span<const rendering::PlacedToolSphere> tool,
                            const rendering::TouchedSpheres& touched,
                            publication::MovingRecords& moving) {
  pushes_.clear();
  sphere_pushes_.clear();
  std::array<double, kMaxPushes> weight_N;
  const auto records = moving.records();
  for (const rendering::TouchedSphere& sphere : touched.all()) {
    const Vector3d force_N = -rendering::sphere_force_of(scene, sphere, tool, pose).force_N;
    const double size_N = force_N.norm();
    if (!(size_N > 0.0)) continue;
    const Vector3d point_m = rendering::contact_with(sphere, tool[sphere.tool_sphere]).point_m -
                             sphere.position_m + vector(records[sphere.number].newest.position_m);
    sphere_pushes_.push_back({sphere.number, force_N});
    auto push = std::find_if(pushes_.begin(), pushes_.end(),
                             [&](const stillgrid_push& p) { return p.body == sphere.body; });
    if (push == pushes_.end()) {
      if (pushes_.size() == kMaxPushes) continue;
      weight_N[pushes_.size()] = 0.0;
      pushes_.push_back({});
      push = pushes_.end() - 1;
      push->body = sphere.body;
    }
    weight_N[static_cast<std::size_t>(push - pushes_.begin())] += size_N;
    ++push->contacts;
    Eigen::Map<Vector3d>(push->force_N) += force_N;
    Eigen::Map<Vector3d>(push->point_m) += size_N * point_m;
    Eigen::Map<Vector3d>(push->torque_N_m) += point_m.cross(force_N);  // about the origin, yet
  }
  for (std::size_t i = 0; i < pushes_.size(); ++i) {
    Eigen::Map<Vector3d> point_m(pushes_[i].point_m);
    point_m /= weight_N[i];
    Eigen::Map<Vector3d>(pushes_[i].torque_N_m) -= point_m.cross(Vector3d(pushes_[i].force_N));
  }
}

double HandPushes::work_J(publication::MovingRecords& moving) const noexcept {
  double work_J = 0.0;
  const auto records = moving.records();
  for (const SpherePush& push : sphere_pushes_) {
    if (push.sphere >= records.size()) continue;
    const proto::SphereRecord& record = records[push.sphere];
    const Vector3d way_m = vector(record.newest.position_m) - vector(record.older[0].position_m);
    if (way_m.allFinite()) work_J += push.force_N.dot(way_m);
  }
  return work_J;
}

}  // namespace stillgrid::library
