#include "sim_server/dynamics/contacts/contact_core.hpp"

#include <algorithm>
#include <numeric>

#include "sim_server/contact/sticking.hpp"

namespace stillgrid::dynamics {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kLanes = ContactRows::kLanes;
/// What one thread takes at once.
constexpr std::size_t kPairsAChunk = 1024, kIslandsAChunk = 16;
/// Pairs of a scene and rows of an island below which threads cost more than they take over.
constexpr std::size_t kPairsWorthSharing = 2048, kRowsWorthSharing = 256;

double sum(const ContactRows::Lane& lane) {
  return std::accumulate(lane.begin(), lane.end(), 0.0);
}

}  // namespace

void ContactCore::take(const bodies::World& world, std::span<const contact::Contact> contacts) {
  list_.take(world, contacts);
  near_.clear();
  rows_.clear();
  is_divided_ = false;
  struck_ = false;
}

const Workers& ContactCore::workers() const noexcept {
  return list_.pairs().size() < kPairsWorthSharing ? Workers::alone() : *workers_;
}

void ContactCore::begin(double share, double part_s, double substep_s, const Vector3d& gravity_m_s2,
                        const ExplicitState& state) {
  list_.place(state, share, substep_s, gravity_m_s2, workers());
  is_near_.resize(list_.pairs().size());
  workers().for_each(list_.pairs().size(), kPairsAChunk, [&](std::size_t i) {
    is_near_[i] = list_.is_near(list_.pairs()[i], share, part_s, substep_s) ? 1 : 0;
  });
  nearer_.clear();
  for (std::size_t i = 0; i < is_near_.size(); ++i)
    if (is_near_[i] != 0) nearer_.push_back(i);
  // What was near before may come back, and costs less than other islands.
  if (!is_divided_ || !std::ranges::includes(near_, nearer_)) divide(state);
  place_given(share, part_s, state);
  for (const Given& touch : touch_lanes_)
    set_field_material(touch.pair, touch.place,
                       rows_[touch.place / kLanes].stiffness_N_per_m[touch.place % kLanes]);
  movers_.note_start(state, workers());
  workers().for_each_chunk(rows_.size(), kRowsAChunk, [&](std::size_t first, std::size_t last) {
    place_rows(std::span(rows_).subspan(first, last - first), list_.spheres(), movers_.velocities(),
               substep_s);
  });
  movers_.reach(rows_, workers());
}

/// Islands and rows of other pairs than before.
void ContactCore::divide(const ExplicitState& state) {
  keep_stretches();
  near_.swap(nearer_);
  is_divided_ = true;
  movers_.clear(list_.spheres().size(), state);
  moved_.clear();
  auto near = near_.begin();
  for (std::size_t i = 0; i < list_.pairs().size(); ++i) {
    if (near == near_.end() || *near != i) {
      list_.memories().forget(i);
      continue;
    }
    ++near;
    const ContactPair& pair = list_.pairs()[i];
    int moved = movers_.enter(list_.sphere(pair.a), -1, state);
    if (pair.b >= 0) moved = movers_.enter(list_.sphere(pair.b), moved, state);
    moved_.push_back(moved);
  }
  movers_.divide(moved_, place_of_);
  sorted_.resize(near_.size());
  for (std::size_t i = 0; i < near_.size(); ++i) sorted_[place_of_[i]] = near_[i];
  rows_.clear();
  lanes_.clear();
  given_.clear();
  touch_lanes_.clear();
  for (std::size_t i = 0; i < movers_.islands().size(); ++i) {
    ContactIsland& island = movers_.islands()[i];
    movers_.begin_island(i);
    island.rows.first = rows_.size();
    for (std::size_t k = island.touches.first; k < island.touches.last; ++k) {
      const std::size_t lane = (k - island.touches.first) % kLanes;
      if (lane == 0) rows_.emplace_back();
      lanes_.push_back((rows_.size() - 1) * kLanes + lane);
      fill_lane(sorted_[k], lanes_.back());
    }
    island.rows.last = rows_.size();
  }
  movers_.note_sides(rows_);
  pushes_.resize(rows_.size() * kLanes);
}

/// What a pair is.
void ContactCore::fill_lane(std::size_t index, std::size_t place) {
  const ContactPair& pair = list_.pairs()[index];
  const contact::Contact& contact = *pair.contact;
  const ContactMemory& memory = list_.memories()[index];
  ContactRows& rows = rows_[place / kLanes];
  const std::size_t lane = place % kLanes;
  rows.set_material(lane, contact.material, contact.is_tool);
  rows.distance_m[lane] = pair.distance_m;
  rows.radius_m[lane] = pair.radius_m;
  rows.is_plane[lane] = contact.is_plane ? 1.0 : 0.0;
  ContactRows::set(rows.stretch_m, lane, memory.stretch_m);
  if (pair.touch >= 0) {
    touch_lanes_.push_back({index, place});
    set_field_material(index, place, memory.stiffness_N_per_m);
  }
  ContactRows::set(rows.normal, lane, contact.is_plane ? contact.plane_normal : memory.normal);
  rows.other_m[lane].map() = contact.plane_offset_m * contact.plane_normal;
  const auto enter = [&](int number, int& point, ContactRows::Lane& turns) {
    const ContactSphere& sphere = list_.sphere(number);
    point = movers_.point_of(number, sphere);
    turns[lane] = sphere.rigid >= 0 ? 1.0 : 0.0;
    rows.weights[lane] += ContactMovers::weight_sum(sphere);
    return point > 0;
  };
  rows.sphere_a[lane] = pair.a;
  rows.sphere_b[lane] = pair.b;
  bool is_moved = enter(pair.a, rows.a[lane], rows.turns_a);
  if (pair.b >= 0) is_moved = enter(pair.b, rows.b[lane], rows.turns_b) && is_moved;
  if (!is_moved || (pair.b < 0 && !contact.is_plane)) given_.push_back({index, place});
}

/// As stiff as a field is where it is met. What sticks holds the energy that it held.
void ContactCore::set_field_material(std::size_t index, std::size_t place, double before_N_per_m) {
  const ContactPair& pair = list_.pairs()[index];
  ContactRows& rows = rows_[place / kLanes];
  const std::size_t lane = place % kLanes;
  const collision::ContactMaterial& material =
      list_.touches()[static_cast<std::size_t>(pair.touch)].material;
  rows.set_material(lane, material, pair.contact->is_tool);
  ContactRows::set(rows.stretch_m, lane,
                   contact::stretched_as(ContactRows::get(rows.stretch_m, lane), before_N_per_m,
                                         material.stiffness_N_per_m));
}

/// Where what contacts do not move is, and how it moves.
void ContactCore::place_given(double share, double part_s, const ExplicitState& state) {
  const auto velocity_m_s = [&](int sphere, int point) {
    const bodies::SphereBinding& binding = *list_.sphere(sphere).binding;
    return point > 0 || binding.rigid < 0
               ? Vector3d(Vector3d::Zero())
               : state.rigid[static_cast<std::size_t>(binding.rigid)].velocity_m_s;
  };
  for (const Given& given : given_) {
    const ContactPair& pair = list_.pairs()[given.pair];
    const contact::Contact& contact = *pair.contact;
    ContactRows& rows = rows_[given.place / kLanes];
    const std::size_t lane = given.place % kLanes;
    const Vector3d a_m_s = velocity_m_s(pair.a, rows.a[lane]);
    Vector3d across_m_s = -a_m_s, along_m_s = -a_m_s;
    if (pair.b >= 0) {
      across_m_s += velocity_m_s(pair.b, rows.b[lane]);
      along_m_s = across_m_s;
    } else if (!contact.is_plane) {
      rows.other_m[lane].map() = list_.other_m(pair, share);
      across_m_s += contact.velocity_b_m_s;
      along_m_s += way_m_s(contact, part_s);
      ContactRows::set(rows.given_spin_rad_s, lane, contact.spin_b_rad_s);
    }
    ContactRows::set(rows.given_across_m_s, lane, across_m_s);
    ContactRows::set(rows.given_along_m_s, lane, along_m_s);
  }
}

/// What sticks has come to what is in the rows.
void ContactCore::keep_stretches() {
  for (std::size_t i = 0; i < lanes_.size() && !rows_.empty(); ++i) {
    ContactMemory& memory = list_.memories()[sorted_[i]];
    const ContactRows& rows = rows_[lanes_[i] / kLanes];
    memory.stretch_m = ContactRows::get(rows.stretch_m, lanes_[i] % kLanes);
    memory.normal = ContactRows::get(rows.normal, lanes_[i] % kLanes);
    memory.stiffness_N_per_m = rows.stiffness_N_per_m[lanes_[i] % kLanes];
  }
}

void ContactCore::keep() {
  keep_stretches();
  list_.memories().keep();
}

ContactSolve ContactCore::solve(double substep_s, const Budget& budget, ExplicitState& state,
                                EnergyFlow& flow) {
  movers_.start(state, workers());
  const std::span<const ContactIsland> islands = movers_.islands();
  // Those who share the work of a large island would wait for one another in small ones.
  const auto is_shared = [](const ContactIsland& island) {
    return island.rows.last - island.rows.first > kRowsWorthSharing;
  };
  solves_.resize(islands.size());
  workers().for_each(islands.size(), kIslandsAChunk, [&](std::size_t i) {
    if (!is_shared(islands[i]))
      solves_[i] = solve_island(islands[i], substep_s, budget, state, Workers::alone());
  });
  for (std::size_t i = 0; i < islands.size(); ++i)
    if (is_shared(islands[i]))
      solves_[i] = solve_island(islands[i], substep_s, budget, state, workers());
  movers_.apply(state, workers());
  end(substep_s, flow);
  ContactSolve worst;
  for (const ContactSolve& own : solves_) worst.add(own);
  return worst;
}

/// What contacts did in a substep.
void ContactCore::end(double substep_s, EnergyFlow& flow) {
  flows_.assign(Workers::chunks_of(rows_.size(), kRowsAChunk), {});
  workers().for_each_chunk(rows_.size(), kRowsAChunk, [&](std::size_t first, std::size_t last) {
    end_rows(std::span(rows_).subspan(first, last - first), movers_.velocities(), substep_s,
             flows_[first / kRowsAChunk]);
  });
  spring_change_J_ = 0.0;
  for (const RowFlow& rows : flows_) {
    struck_ = struck_ || rows.struck;
    spring_change_J_ += sum(rows.spring_change_J);
    flow.friction_J += sum(rows.friction_J);
    flow.contact_damping_J += sum(rows.damping_J);
    flow.unsolved_J += sum(rows.unsolved_J);
    flow.given_J += sum(rows.given_J);
  }
  for (const Given& given : given_) {
    const contact::Contact& contact = *list_.pairs()[given.pair].contact;
    if (!contact.is_tool) continue;
    const ContactRows& rows = rows_[given.place / kLanes];
    const std::size_t lane = given.place % kLanes;
    flow.tool_J[static_cast<std::size_t>(contact.hand)] +=
        ContactRows::get(rows.impulse_N_s, lane).dot(ContactRows::get(rows.given_m_s, lane));
  }
  flow.friction_J += list_.memories().take_parted_J();
}

}  // namespace stillgrid::dynamics
