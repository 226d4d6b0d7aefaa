#include "shared/library/body_pushes.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "shared/collision/grid_query.hpp"
#include "shared/dynamics/engine.hpp"
#include "shared/library/vectors.hpp"

namespace stillgrid::library {
namespace {

using Eigen::Vector3d;
using local::GivenBody;
using local::Twist;

/// Spheres looked at.
constexpr std::size_t kMaxNear = 16 * local::kMaxGivenSpheres;

const GivenBody* body_of(std::span<const GivenBody> given, std::uint32_t number) noexcept {
  const auto body = std::ranges::lower_bound(given, number, {}, &GivenBody::number);
  return body != given.end() && body->number == number ? &*body : nullptr;
}

}  // namespace

BodyPushes::BodyPushes(const local::GivenModel& model)
    : bodies_(model), poses_(model.tools.size()), work_J_(model.tools.size()) {
  for (const local::GivenModel::Tool& tool : model.tools) {
    double& radius_m = radius_m_.emplace_back(0.0);
    for (const local::GivenModel::ToolSphere& sphere : tool.spheres)
      radius_m = std::max(radius_m, sphere.centre_m.norm() + sphere.radius_m);
  }
  near_.reserve(kMaxNear);
  groups_.reserve(kMaxNear);
  state_.bodies.reserve(local::kMaxHeldBodies);
  state_.spheres.reserve(local::kMaxGivenSpheres);
  pushes_.reserve(local::kMaxHeldBodies * model.tools.size());
  wrenches_.reserve(local::kMaxHeldBodies);
  state_.proxies.reserve(local::kMaxGivenProxies);
  proxies_.reserve(local::kMaxGivenProxies);
  block_.reserve(local::given_state_capacity(SIZE_MAX));
}

void BodyPushes::clear() noexcept {
  pushes_.clear();
  wrenches_.clear();
  std::ranges::fill(work_J_, 0.0);
}

Twist BodyPushes::wrench_of(std::uint32_t body) const noexcept {
  const auto found = std::ranges::lower_bound(wrenches_, body, {},
                                              [](const auto& wrench) { return wrench.first; });
  return found != wrenches_.end() && found->first == body ? found->second : Twist::Zero();
}

/// A ball that holds the tool's origin in these ticks; none where the tool is away.
std::optional<BodyPushes::Ball> BodyPushes::ball_of(const HandPath& hand, std::uint64_t from,
                                                    std::uint64_t to) const noexcept {
  std::optional<std::pair<Vector3d, Vector3d>> box;
  for (std::uint64_t tick = from; tick <= to; ++tick) {
    const auto pose = dynamics::led_on_pose(hand.path, tick, hand.led_on_ticks);
    if (!pose) continue;
    if (!box) box = {pose->position_m, pose->position_m};
    box->first = box->first.cwiseMin(pose->position_m);
    box->second = box->second.cwiseMax(pose->position_m);
  }
  if (!box) return std::nullopt;
  return Ball{0.5 * (box->first + box->second), 0.5 * (box->second - box->first).norm()};
}

/// Adds the spheres that are in the ball, or come there in that time. Returns whether there was
/// room for all.
bool BodyPushes::find_near(publication::MovingRecords& moving, const Ball& ball,
                           double ahead_s) noexcept {
  const auto records = moving.records();
  bool is_whole = true;
  double fastest_m_s = 0.0;  // a swept bound holds where its sphere was
  if (ahead_s > 0.0)
    for (const proto::SphereRecord& record : records)
      fastest_m_s = std::max(fastest_m_s, vector(record.newest.velocity_m_s).norm());
  collision::for_each_candidate(
      moving.grid().view(),
      collision::bound_sphere(ball.centre_m, ball.radius_m + ahead_s * fastest_m_s),
      collision::kAllVisits, [&](std::uint32_t number) {
        const proto::SphereRecord& record = records[number];
        const double distance_m = (vector(record.newest.position_m) - ball.centre_m).norm() -
                                  double{record.radius_m} -
                                  ahead_s * vector(record.newest.velocity_m_s).norm();
        if (!(distance_m < ball.radius_m)) return;
        is_whole = is_whole && near_.size() < kMaxNear;
        if (is_whole) near_.push_back({record.body, number, distance_m});
      });
  return is_whole;
}

/// Groups near spheres by their bodies, the nearest body first. Two tools may be near one sphere.
void BodyPushes::group() noexcept {
  const auto order = [](const Near& near) { return std::tuple(near.body, near.sphere); };
  std::ranges::sort(near_, {}, order);
  const auto is_same = [&](const Near& a, const Near& b) { return order(a) == order(b); };
  near_.erase(std::unique(near_.begin(), near_.end(), is_same), near_.end());
  std::ranges::sort(near_, {}, [](const Near& near) {
    return std::tuple(near.body, near.distance_m, near.sphere);
  });
  groups_.clear();
  for (std::size_t i = 0; i < near_.size(); ++i) {
    if (groups_.empty() || groups_.back().body != near_[i].body)
      groups_.push_back({near_[i].body, i, 0, near_[i].distance_m});
    ++groups_.back().count;
  }
  std::ranges::sort(groups_, {},
                    [](const Group& group) { return std::tuple(group.distance_m, group.body); });
}

/// The state of the groups, by number of body.
void BodyPushes::fill(publication::MovingRecords& moving,
                      std::span<const GivenBody> given) noexcept {
  state_.bodies.clear();
  state_.spheres.clear();
  state_.proxies.clear();
  std::ranges::sort(groups_, {}, &Group::body);
  const auto records = moving.records();
  for (const Group& group : groups_) {
    const GivenBody* body = body_of(given, group.body);
    const auto index = static_cast<std::uint32_t>(state_.bodies.size());
    GivenBody& added = state_.bodies.emplace_back();
    if (body != nullptr) {
      added = *body;
    } else {
      added.number = group.body;
      added.centre_m = vector(records[near_[group.first].sphere].newest.position_m);
    }
    const auto first = near_.begin() + static_cast<std::ptrdiff_t>(group.first);
    std::sort(first, first + static_cast<std::ptrdiff_t>(group.count),
              [](const Near& a, const Near& b) { return a.sphere < b.sphere; });
    for (std::size_t i = group.first; i < group.first + group.count; ++i) {
      const proto::SphereRecord& record = records[near_[i].sphere];
      local::GivenSphere& sphere = state_.spheres.emplace_back();
      sphere = {.body = index,
                .number = near_[i].sphere,
                .material = record.material,
                .radius_m = double{record.radius_m},
                .arm_m = vector(record.newest.position_m) - added.centre_m};
      if (body == nullptr) sphere.own_m_s = vector(record.newest.velocity_m_s);
    }
  }
}

/// Whether the proxies of the last pushes are those of a state at a tick.
bool BodyPushes::goes_on_at(std::uint64_t tick) const noexcept {
  constexpr std::uint64_t kOldest = 100;  // ticks
  return !proxies_.empty() &&
         std::max(tick, proxies_tick_) - std::min(tick, proxies_tick_) <= kOldest;
}

/// Gives the state the proxies of the last pushes. Each goes with the sphere that carries it, which
/// is about where it was led.
void BodyPushes::begin_proxies() noexcept {
  constexpr double kAbout = 0.125;  // of the distance between both centres
  state_.proxies.assign(proxies_.begin(), proxies_.end());
  for (local::GivenProxy& proxy : state_.proxies) {
    const auto it = std::ranges::find(state_.spheres, proxy.carrier, &local::GivenSphere::number);
    if (it == state_.spheres.end() || state_.bodies[it->body].number != proxy.carrier_body)
      continue;
    const Vector3d now_m = state_.bodies[it->body].centre_m + it->arm_m + proxy.arm_m;
    // The publisher may have given another sphere the number.
    if ((now_m - proxy.position_m).norm() < kAbout * proxy.arm_m.norm()) proxy.position_m = now_m;
  }
}

void BodyPushes::find(publication::MovingRecords& moving, std::span<const GivenBody> given,
                      std::span<const HandPath> hands, std::uint64_t from,
                      std::uint64_t to) noexcept {
  clear();
  near_.clear();
  const auto ticks = static_cast<double>(to - from);
  for (std::size_t hand = 0; hand < hands.size(); ++hand) {
    std::optional<Ball> ball = ball_of(hands[hand], from, to);
    if (!ball) continue;
    // Bodies turn, and are pushed on. Proxies are behind.
    ball->radius_m += 4.0 * radius_m_[hand] + bodies_.tools().behind_m(hand);
    (void)find_near(moving, *ball, ticks * dynamics::kTick_s);
  }
  const bool goes_on = goes_on_at(from);
  if (near_.empty()) return proxies_.clear();
  group();
  std::size_t room = local::kMaxGivenSpheres;
  groups_.resize(std::min(groups_.size(), local::kMaxHeldBodies));
  for (Group& group : groups_) room -= group.count = std::min(group.count, room);
  std::erase_if(groups_, [](const Group& group) { return group.count == 0; });
  fill(moving, given);
  if (goes_on) begin_proxies();
  const auto poses_at = [&](std::uint64_t tick) {
    for (std::size_t hand = 0; hand < hands.size(); ++hand)
      poses_[hand] = dynamics::led_on_pose(hands[hand].path, tick, hands[hand].led_on_ticks);
    return std::span(std::as_const(poses_));
  };
  bodies_.begin(state_, poses_at(from));
  for (std::uint64_t tick = from + 1; tick <= to; ++tick) bodies_.step(poses_at(tick));
  proxies_.assign(bodies_.tools().proxies().begin(), bodies_.tools().proxies().end());
  proxies_tick_ = to;
  for (const GivenBody& body : state_.bodies) wrenches_.emplace_back(body.number, Twist::Zero());
  for (std::size_t hand = 0; hand < hands.size(); ++hand) tell(hand, ticks);
}

/// Makes one hand's pushes of what the bodies felt in all ticks.
void BodyPushes::tell(std::size_t hand, double ticks) noexcept {
  for (std::size_t i = 0; i < state_.bodies.size(); ++i) {
    const local::GivenBodies::Push& all = bodies_.push(hand, i);
    if (!(all.weight_N > 0.0) || !all.wrench.allFinite()) continue;
    const Twist wrench = all.wrench / (ticks * dynamics::kTick_s);
    const Vector3d arm_m = all.weighted / all.weight_N, force_N = wrench.head<3>();
    wrenches_[i].second += wrench;
    work_J_[hand] += all.work_J;
    stillgrid_push& push = pushes_.emplace_back();
    push = {};
    push.body = state_.bodies[i].number;
    push.contacts = static_cast<std::uint32_t>(all.contacts);
    Eigen::Map<Vector3d>(push.force_N) = force_N;
    Eigen::Map<Vector3d>(push.point_m) = state_.bodies[i].centre_m + arm_m;
    Eigen::Map<Vector3d>(push.torque_N_m) = wrench.tail<3>() - arm_m.cross(force_N);
  }
}

std::span<const std::byte> BodyPushes::state_at(std::uint64_t tick,
                                                publication::MovingRecords& moving,
                                                std::span<const GivenBody> given,
                                                std::span<const HandPath> hands, double margin_m) {
  bool is_whole = false;
  for (int tries = 0; tries < 4 && !is_whole; ++tries, margin_m *= 0.5) {
    is_whole = true;
    near_.clear();
    for (std::size_t hand = 0; hand < hands.size(); ++hand)
      if (std::optional<Ball> ball = ball_of(hands[hand], tick, tick)) {
        ball->radius_m += radius_m_[hand] + margin_m;
        is_whole = find_near(moving, *ball, 0.0) && is_whole;
      }
    is_whole = is_whole && near_.size() <= 2 * local::kMaxGivenSpheres;
  }
  if (!is_whole) return {};
  std::erase_if(near_, [&](const Near& near) { return body_of(given, near.body) == nullptr; });
  group();
  std::size_t room = local::kMaxGivenSpheres, bodies = local::kMaxGivenBodies;
  std::erase_if(groups_, [&](const Group& group) {
    const bool fits = group.count <= room && bodies > 0;
    if (fits) room -= group.count, --bodies;
    return !fits;
  });
  fill(moving, given);
  if (goes_on_at(tick)) begin_proxies();
  encode(state_, block_);
  return block_;
}

}  // namespace stillgrid::library
