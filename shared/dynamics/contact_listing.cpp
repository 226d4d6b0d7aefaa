#include "shared/dynamics/contact_listing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "shared/collision/smooth_cover.hpp"
#include "shared/dynamics/at.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr std::size_t kKinds = 3;           // without planes
constexpr double kSkin = 0.03;              // of a radius: a sphere at rest may move by it
constexpr double kTicksAhead = 20.0;        // that the listing of a slow sphere lasts
constexpr double kFarthestAhead = 0.2;      // of a radius, beyond the next tick
constexpr double kTouching = 1e-3;          // of the radii: the gap that rows of the touching have
constexpr double kBallInertia = 0.4;        // of mass times square of radius
constexpr double kInertiaTolerance = 1e-9;  // share by which that of a ball may differ
constexpr std::size_t kLeastLanes = 4;      // of a row, on average, of contacts solved in turn

/// Groups in the order in which they are solved: planes, those that touch, those that are near.
std::size_t group_of(SideKind a, SideKind b, bool touches) {
  if (b == SideKind::kPlane) return static_cast<std::size_t>(a);
  const std::size_t pair = static_cast<std::size_t>(a) * kKinds + static_cast<std::size_t>(b);
  return kKinds + (touches ? 0 : kKinds * kKinds) + pair;
}
std::pair<SideKind, SideKind> kinds_of(std::size_t group) {
  if (group < kKinds) return {static_cast<SideKind>(group), SideKind::kPlane};
  const std::size_t pair = (group - kKinds) % (kKinds * kKinds);
  return {static_cast<SideKind>(pair / kKinds), static_cast<SideKind>(pair % kKinds)};
}

}  // namespace

SideKind side_kind(const Description& description, const Description::Sphere& sphere) {
  if (sphere.rigid < 0) return SideKind::kSoft;
  const Description::Rigid& rigid = description.rigid_bodies[at(sphere.rigid)];
  if (rigid.is_driven || sphere.local_m.norm() > 0.0) return SideKind::kRigid;
  const double ball = kBallInertia * rigid.mass_kg * sphere.radius_m * sphere.radius_m;
  const Eigen::Array3d differs = (rigid.inertia_kg_m2.array() - ball).abs();
  return (differs <= kInertiaTolerance * ball).all() ? SideKind::kBall : SideKind::kRigid;
}

Vector4 sphere_position_m(const Description::Sphere& sphere, const SceneState& state) {
  if (sphere.rigid >= 0) {
    const Vector4& centre = state.rigid_position_m[at(sphere.rigid)];
    if (sphere.local_m.isZero(0.0)) return centre;
    return centre + Vector4(state.orientation[at(sphere.rigid)].quaternion() * sphere.local_m);
  }
  Vector4 sum;
  for (std::size_t k = 0; k < at(sphere.node_count); ++k)
    sum = sum + sphere.weights[k] * state.node_position_m[at(sphere.nodes[k])];
  return sum;
}

double listing_margin_m(double length_m, double next_m) {
  return kSkin * length_m + std::min(kTicksAhead * next_m, next_m + kFarthestAhead * length_m);
}

namespace {

/// The radius; of a surface point, which is far smaller than its solid, the cell of its field.
double length_m(const Description& description, const Description::Sphere& sphere) {
  double length = sphere.radius_m;
  for (const Description::Field& field : description.fields)
    if (sphere.is_field_point && sphere.rigid == field.rigid)
      length = std::max(length, field_cell_m(field));
  return length;
}

}  // namespace

double highest_speed_m_s(const Description::Sphere& sphere, const SceneState& state) {
  if (sphere.rigid >= 0)
    return state.rigid_velocity_m_s[at(sphere.rigid)].vector().norm() +
           state.angular_velocity_rad_s[at(sphere.rigid)].vector().norm() * sphere.local_m.norm();
  double most = 0.0;
  for (int k = 0; k < sphere.node_count; ++k)
    most = std::max(most, state.node_velocity_m_s[at(sphere.nodes[at(k)])].vector().norm());
  return most;
}

Eigen::Vector3d sphere_velocity_m_s(const Description::Sphere& sphere, const SceneState& state) {
  if (sphere.rigid >= 0) {
    const auto r = at(sphere.rigid);
    const Eigen::Vector3d arm = state.orientation[r].quaternion() * sphere.local_m;
    return state.rigid_velocity_m_s[r].vector() +
           state.angular_velocity_rad_s[r].vector().cross(arm);
  }
  Vector4 sum;
  for (std::size_t k = 0; k < at(sphere.node_count); ++k)
    sum = sum + sphere.weights[k] * state.node_velocity_m_s[at(sphere.nodes[k])];
  return sum.vector();
}

ContactListing::ContactListing(const Description& description)
    : description_(description), candidates_(kKinds + 2 * kKinds * kKinds) {
  constexpr std::size_t kReserved = 8;  // pairs of a sphere: which kinds will touch is not known
  packer_.reserve(kReserved * description.spheres.size() / kLeastLanes);
  for (auto& group : candidates_) group.reserve(kReserved * description.spheres.size());
  // Balls are alone on their body, and feel contacts and gravity only.
  std::vector<int> spheres(description.rigid_bodies.size());
  for (const Description::Sphere& sphere : description.spheres)
    if (sphere.rigid >= 0) ++spheres[at(sphere.rigid)];
  for (const Description::Field& field : description.fields) spheres[at(field.rigid)] += 2;
  for (const Description::Joint& joint : description.joints)
    for (const Description::JointEnd& end : {joint.a, joint.b})
      if (end.rigid >= 0) spheres[at(end.rigid)] += 2;
  for (const Description::Sphere& sphere : description.spheres) {
    SideKind kind = side_kind(description, sphere);
    if (kind == SideKind::kBall && spheres[at(sphere.rigid)] > 1) kind = SideKind::kRigid;
    if (sphere.has_proxy()) tools_.push_back(static_cast<std::int32_t>(kinds_.size()));
    kinds_.push_back(kind);
    lengths_m_.push_back(length_m(description, sphere));
  }
  for (const collision::ContactMaterial& a : description.materials)
    for (const collision::ContactMaterial& b : description.materials) {
      const collision::ContactMaterial pair = collision::pair_material(a, b);
      constants_.push_back({static_cast<float>(pair.stiffness_N_per_m),
                            static_cast<float>(pair.damping_N_s_per_m),
                            static_cast<float>(pair.friction), 0.0F});
    }
  known_.reserve(kReserved * description.spheres.size());
  divided_.reserve(kReserved * description.spheres.size());
  rows_.groups.reserve(candidates_.size() + 3 * kContactParts);
  sleeping_contacts_.reserve(description.spheres.size());  // most spheres of a pile have one
  tool_lanes_.reserve(tools_.size() * sides_reserved());
  fixtures_.reserve(tools_.size() * sides_reserved());
}

std::size_t ContactListing::sides_reserved() const {
  constexpr std::size_t kMaxSides = 256;  // ten times those of the shipped scenes
  return std::min(kMaxSides, description_.field_number(description_.fields.size()));
}

/// Slow spheres may move for many ticks before contacts are listed anew, fast ones less far.
void ContactListing::bound_ways(const SceneState& state, double tick_s) {
  const double falls = description_.gravity_m_s2.norm() * tick_s * tick_s;
  bases_.resize(description_.spheres.size());
  for (std::size_t s = 0; s < bases_.size(); ++s) {
    const Description::Sphere& sphere = description_.spheres[s];
    const double next = highest_speed_m_s(sphere, state) * tick_s;
    bases_[s] = sphere_position_m(sphere, state);
    bases_[s].w = listing_margin_m(lengths_m_[s], next) + falls;
  }
  for (std::size_t t = 0; t < tools_.size(); ++t) {
    Vector4& base = bases_[at(tools_[t])];
    base.w += (state.proxy_m[t].vector() - base.vector()).norm();
  }
}

/// Lists spheres that are here: those that may move, then those that never do and that these may
/// reach. Returns how many never move.
std::size_t ContactListing::find_here(const SceneState& state) {
  here_.clear();
  balls_.clear();
  Eigen::AlignedBox3d reach;  // a box around all that may move
  const auto extend = [&](const Eigen::Vector3d& centre_m, double radius_m) {
    const Eigen::Vector3d corner_m = Eigen::Vector3d::Constant(radius_m);
    reach.extend(Eigen::AlignedBox3d(centre_m - corner_m, centre_m + corner_m));
  };
  const auto is_away = [&](int rigid) { return rigid >= 0 && state.is_here[at(rigid)] == 0; };
  const auto add_spheres = [&](bool are_fixtures) {
    for (std::size_t s = 0; s < bases_.size(); ++s) {
      const Description::Sphere& sphere = description_.spheres[s];
      if (description_.is_fixture(sphere.rigid) != are_fixtures || is_away(sphere.rigid)) continue;
      Vector4 ball = bases_[s];
      ball.w += sphere.radius_m;
      if (sphere.has_proxy()) ball.w += collision::SmoothCover::margin_m(sphere.radius_m);
      // What is no number is listed.
      if (are_fixtures && reach.squaredExteriorDistance(ball.vector()) > ball.w * ball.w) continue;
      if (!are_fixtures) extend(ball.vector(), ball.w);
      here_.push_back(static_cast<std::int32_t>(s));
      balls_.push_back(ball);
    }
    return here_.size();
  };
  const std::size_t moving = add_spheres(false);
  for (std::size_t f = 0; f < description_.fields.size(); ++f) {
    const Description::Field& field = description_.fields[f];
    if (description_.is_fixture(field.rigid) || is_away(field.rigid)) continue;
    const FieldPose pose = field_base_[f].pose();
    extend(pose.position_m + pose.axes * field_centre_m(field),
           field_radius_m(field) + field_base_[f].position_m.w);
  }
  return add_spheres(true) - moving;
}

/// Spheres that are away or out of reach come last.
void ContactListing::order_spheres() {
  order_.clear();
  seen_.assign(bases_.size(), 0);
  for (const std::int32_t ball : pairs_.order()) {
    order_.push_back(here_[at(ball)]);
    seen_[at(order_.back())] = 1;
  }
  for (std::int32_t s = 0; s < static_cast<std::int32_t>(bases_.size()); ++s)
    if (seen_[at(s)] == 0) order_.push_back(s);
}

/// Balls are the first of the rigid bodies, in the order of spheres.
void ContactListing::order_movers() {
  rigid_order_.clear();
  mover_of_rigid_.assign(description_.rigid_bodies.size(), -1);
  const auto nodes = static_cast<std::int32_t>(description_.nodes.size());
  const auto add = [&](std::int32_t rigid) {
    if (mover_of_rigid_[at(rigid)] >= 0) return;
    mover_of_rigid_[at(rigid)] = nodes + static_cast<std::int32_t>(rigid_order_.size());
    rigid_order_.push_back(rigid);
  };
  for (const std::int32_t s : order_)
    if (kinds_[at(s)] == SideKind::kBall && !sleeps(s)) add(description_.spheres[at(s)].rigid);
  for (const std::int32_t s : order_)
    if (kinds_[at(s)] == SideKind::kRigid && !sleeps(s)) add(description_.spheres[at(s)].rigid);
  for (std::size_t r = 0; r < mover_of_rigid_.size(); ++r)
    if (rigid_sleeps_.empty() || rigid_sleeps_[r] == 0) add(static_cast<std::int32_t>(r));
  rigid_awake_ = rigid_order_.size();
  for (std::size_t r = 0; r < mover_of_rigid_.size(); ++r) add(static_cast<std::int32_t>(r));
}

void ContactListing::collect_near() {
  near_spheres_.clear();
  tool_places_.resize(tools_.size());
  for (const std::int32_t s : order_) {
    const auto tool = std::ranges::lower_bound(tools_, s);
    if (tool != tools_.end() && *tool == s)
      tool_places_[static_cast<std::size_t>(tool - tools_.begin())] = near_spheres_.size();
    const Description::Sphere& sphere = description_.spheres[at(s)];
    near_spheres_.push_back(
        {.rigid = sphere.rigid,
         .body = sphere.body,
         .mover = sphere.rigid >= 0 ? mover_of_rigid_[at(sphere.rigid)] : sphere.nodes[0],
         .kind = kinds_[at(s)],
         .is_driven = sphere.rigid >= 0 && description_.rigid_bodies[at(sphere.rigid)].is_driven,
         .is_still = is_still(s),
         .material = sphere.material,
         .is_tool = sphere.is_tool,
         .tool_slip_speed_m_s = static_cast<float>(sphere.tool_slip_speed_m_s),
         .is_field_point = sphere.is_field_point,
         .radius_m = sphere.radius_m});
  }
  collect_near_fields();
}

namespace {

/// Whether a sorted list has a pair, smaller number first.
bool has_pair(const std::vector<std::pair<int, int>>& pairs, int i, int j) {
  return std::ranges::binary_search(pairs, std::pair(std::min(i, j), std::max(i, j)));
}

}  // namespace

bool ContactListing::may_collide(std::int32_t place, std::int32_t other) const {
  const NearSphere &a = near_spheres_[at(place)], &b = near_spheres_[at(other)];
  if (a.rigid >= 0 && a.rigid == b.rigid) return false;
  // A tool feels driven bodies, though nothing moves.
  const bool is_felt = a.is_tool != b.is_tool;
  if (a.is_driven && b.is_driven && !is_felt) return false;
  if (a.is_field_point || b.is_field_point) return false;
  return a.body == b.body
             ? !has_pair(description_.apart_spheres, order_[at(place)], order_[at(other)])
             : !has_pair(description_.apart, a.body, b.body);
}

/// Whether a pair may touch. A proxy's neighbours of what it touches may, too.
bool ContactListing::may_be_near(std::int32_t place, std::int32_t other) const {
  if (has_proxy(other)) std::swap(place, other);
  if (!has_proxy(place)) return true;
  const NearSphere &a = near_spheres_[at(place)], &b = near_spheres_[at(other)];
  const double near_m = base_[at(place)].w + base_[at(other)].w + a.radius_m + b.radius_m +
                        collision::SmoothCover::neighbour_gap_m(a.radius_m, b.radius_m);
  return (base_[at(place)] - base_[at(other)]).vector().squaredNorm() < near_m * near_m;
}

void ContactListing::gather() {
  fixtures_.clear();
  for (auto& group : candidates_) group.clear();
  for (const NearPair& pair : pairs_.pairs()) {
    std::int32_t a = pair.first, b = pair.second;
    if (!may_collide(a, b) || !may_be_near(a, b) || add_fixture(a, b)) continue;
    if (near_spheres_[at(a)].is_still && near_spheres_[at(b)].is_still) continue;
    if (near_spheres_[at(a)].kind > near_spheres_[at(b)].kind) std::swap(a, b);
    const NearSphere &near_a = near_spheres_[at(a)], &near_b = near_spheres_[at(b)];
    const double touching = (1.0 + kTouching) * (near_a.radius_m + near_b.radius_m);
    const Vector4 apart = base_[at(a)] - base_[at(b)];
    const bool touches = apart.vector().squaredNorm() < touching * touching;
    candidates_[group_of(near_a.kind, near_b.kind, touches)].push_back({a, b});
  }
  for (std::int32_t place = 0; place < static_cast<std::int32_t>(here_.size()); ++place) {
    const NearSphere& sphere = near_spheres_[at(place)];
    if (sphere.is_driven || sleeps(order_[at(place)])) continue;
    const Vector4& base = base_[at(place)];
    for (std::size_t p = 0; p < description_.planes.size(); ++p) {
      const Description::Plane& plane = description_.planes[p];
      if (plane.normal.dot(base.vector()) - plane.offset_m < sphere.radius_m + base.w &&
          !has_pair(description_.apart, sphere.body, plane.body))
        candidates_[group_of(sphere.kind, SideKind::kPlane, true)].push_back(
            {place, static_cast<std::int32_t>(p)});
    }
  }
}

void ContactListing::add_candidate(std::int32_t a, std::int32_t b, SideKind kind_b) {
  candidates_[group_of(near_spheres_[at(a)].kind, kind_b, true)].push_back({a, b});
}

std::size_t ContactListing::movers_of(std::int32_t place, std::int32_t* movers) const {
  const NearSphere& sphere = near_spheres_[at(place)];
  std::size_t count = 0;
  if (sphere.rigid >= 0) {
    if (!sphere.is_driven) movers[count++] = sphere.mover;
    return count;
  }
  const Description::Sphere& soft = description_.spheres[at(order_[at(place)])];
  for (std::size_t k = 0; k < at(soft.node_count); ++k)
    if (!description_.nodes[at(soft.nodes[k])].is_pinned) movers[count++] = soft.nodes[k];
  return count;
}

/// Sorts the candidates of a group by parts of space, by counting.
void ContactListing::divide(std::size_t group) {
  const auto kinds = kinds_of(group);
  const std::vector<Candidate>& candidates = candidates_[group];
  const auto part = [&](const Candidate& pair) -> std::size_t {
    if (!is_of_balls(kinds.first, kinds.second)) return 0;
    return part_of(order_.size(), at(pair.a),
                   at(kinds.second == SideKind::kPlane ? pair.a : pair.b));
  };
  part_end_.assign(kContactParts, 0);
  for (const Candidate& pair : candidates) ++part_end_[part(pair)];
  std::exclusive_scan(part_end_.begin(), part_end_.end(), part_end_.begin(), std::size_t{0});
  divided_.resize(candidates.size());
  for (std::size_t k = 0; k < candidates.size(); ++k)
    divided_[part_end_[part(candidates[k])]++] = static_cast<std::int32_t>(k);
}

/// Packs candidates of a group in rows. Without in_turn rows may hold a mover twice, and all but
/// the last are full. Returns whether the rows are full enough to be solved so; those of balls
/// always are.
bool ContactListing::pack(std::size_t group, std::span<const std::int32_t> part, bool is_in_turn) {
  packer_.start(description_.nodes.size() + description_.rigid_bodies.size());
  const auto [kind_a, kind_b] = kinds_of(group);
  const bool is_plane = kind_b == SideKind::kPlane;
  const std::size_t most =
      is_in_turn && !is_of_balls(kind_a, kind_b) ? part.size() / kLeastLanes : part.size();
  std::array<std::int32_t, 8> movers{};
  for (std::size_t k = 0; k < part.size() && packer_.rows().size() <= most; ++k) {
    const Candidate& pair = candidates_[group][at(part[k])];
    std::size_t count = is_in_turn ? movers_of(pair.a, movers.data()) : 0;
    if (is_in_turn && !is_plane) count += movers_of(pair.b, movers.data() + count);
    packer_.add(part[k], std::span(movers).first(count));
  }
  packer_.finish();
  return packer_.rows().size() <= most;
}

void ContactListing::pack() {
  rows_.groups.clear();
  rows_.rows.clear();
  rows_.places.clear();
  for (std::size_t g = 0; g < candidates_.size(); ++g) {
    if (candidates_[g].empty()) continue;
    const auto kinds = kinds_of(g);
    divide(g);
    const auto add_part = [&](std::size_t p) {
      const std::size_t first = p == 0 ? 0 : part_end_[p - 1], count = part_end_[p] - first;
      if (count == 0) return;
      const auto part = std::span<const std::int32_t>(divided_).subspan(first, count);
      const bool is_in_turn = may_be_in_turn(kinds.first, kinds.second) && pack(g, part, true);
      if (!is_in_turn) pack(g, part, false);
      add_rows(g, is_in_turn ? 1 : 0, static_cast<std::uint32_t>(p));
    };
    for (std::size_t p = 1; p < kContactParts; p += 2) add_part(p);
    for (std::size_t p = 2; p < kContactParts; p += 2) add_part(p);
    add_part(0);
  }
}

void ContactListing::add_rows(std::size_t group, std::uint32_t is_in_turn, std::uint32_t part) {
  const auto [kind_a, kind_b] = kinds_of(group);
  const std::size_t first = rows_.rows.size(), end = first + packer_.rows().size();
  rows_.groups.push_back({.a = kind_a,
                          .b = kind_b,
                          .first = first,
                          .end = end,
                          .is_in_turn = is_in_turn,
                          .part = part});
  rows_.rows.resize(end);
  rows_.places.resize(end);
  for (std::size_t row = first; row < end; ++row)
    for (std::size_t lane = 0; lane < kRowLanes; ++lane) {
      const std::int32_t item = packer_.rows()[row - first][lane];
      rows_.places[row].sphere_a[lane] = item < 0 ? -1 : candidates_[group][at(item)].a;
      rows_.places[row].sphere_b[lane] = item < 0 ? -1 : candidates_[group][at(item)].b;
    }
}

void ContactListing::list(const SceneState& state, double tick_s, const WorkSharing& sharing) {
  ++listings_;
  remember(sharing);
  bound_ways(state, tick_s);
  bound_field_ways(state, tick_s);
  const std::size_t still = find_here(state);
  pairs_.find(balls_, still, sharing);
  order_spheres();
  order_movers();
  collect_near();
  base_.clear();
  for (const std::int32_t s : order_) base_.push_back(bases_[at(s)]);
  gather();
  gather_fields(state);
  pack();
  derive(sharing);
  recall(sharing);
  list_sleeper_lanes();
  if (is_sleep_new_) add_sleepers();
  is_sleep_new_ = false;
}

}  // namespace stillgrid::dynamics
