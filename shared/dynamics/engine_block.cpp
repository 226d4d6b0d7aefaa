// The whole state of an engine as one block of bytes.
#include <cmath>
#include <stdexcept>
#include <utility>

#include "shared/dynamics/byte_block.hpp"
#include "shared/dynamics/engine.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr std::uint64_t kFormat = 0x36'6b636f6c62'6773;  // "sgblock6"; counts up with the layout

double rate(BlockReader& reader) {
  const auto value = reader.number<double>();
  if (!(value >= 0.0) || !std::isfinite(value))
    throw std::invalid_argument("the block has a rate that is not a positive number");
  return value;
}

template <class T>
void read_as_many(BlockReader& reader, std::vector<T>& values, std::size_t count) {
  reader.read(values);
  if (values.size() != count)
    throw std::invalid_argument("the block is of a scene of other bodies");
}

/// Calls a visitor with each array: of nodes, of rigid bodies, of tools with proxies.
template <class State, class Nodes, class Rigid, class Tools>
void each_array(State& state, const Nodes& nodes, const Rigid& rigid, const Tools& tools) {
  nodes(state.node_position_m);
  nodes(state.node_velocity_m_s);
  rigid(state.rigid_position_m);
  rigid(state.rigid_velocity_m_s);
  rigid(state.orientation);
  rigid(state.angular_velocity_rad_s);
  rigid(state.is_here);
  tools(state.proxy_m);
  tools(state.proxy_stretch_m);
}

}  // namespace

void Engine::save(std::vector<std::byte>& block) const {
  BlockWriter writer(block);
  const auto add = [&](const auto& values) { writer.add(values); };
  writer.add(kFormat);
  writer.add(fingerprint_);
  writer.add(state_.tick);
  writer.add(state_.contacts.stiffness_per_s2);
  writer.add(state_.contacts.damping_per_s);
  writer.add<std::uint64_t>(is_stale_ ? 1 : 0);
  each_array(state_, add, add, add);
  writer.add(sleep_.saved().rested_s);
  writer.add(sleep_.saved().island);
  listing_.save(saved_);
  writer.add(saved_.base);
  writer.add(saved_.order);
  writer.add(saved_.groups);
  writer.add(saved_.sphere_a);
  writer.add(saved_.sphere_b);
  writer.add(saved_.field_base);
  writer.add(saved_.history);
  writer.add(saved_.sleeping);
  writer.add(saved_.fixtures);
  writer.add(held_J_);
}

void Engine::load(std::span<const std::byte> block) {
  BlockReader reader(block);
  if (reader.number<std::uint64_t>() != kFormat)
    throw std::invalid_argument("the block is not of this version of the engine");
  if (reader.number<std::uint64_t>() != fingerprint_)
    throw std::invalid_argument("the block is of another scene");
  SceneState& state = loaded_;
  state.tick = reader.number<std::uint64_t>();
  state.contacts = {rate(reader), rate(reader)};
  const bool is_stale = reader.number<std::uint64_t>() != 0;
  each_array(
      state, [&](auto& values) { read_as_many(reader, values, description_.nodes.size()); },
      [&](auto& values) { read_as_many(reader, values, description_.rigid_bodies.size()); },
      [&](auto& values) { read_as_many(reader, values, listing_.tools().size()); });
  Sleep::Saved& sleep = loaded_sleep_;
  read_as_many(reader, sleep.rested_s, description_.bodies.size());
  read_as_many(reader, sleep.island, description_.bodies.size());
  reader.read(saved_.base);
  reader.read(saved_.order);
  reader.read(saved_.groups);
  reader.read(saved_.sphere_a);
  reader.read(saved_.sphere_b);
  reader.read(saved_.field_base);
  reader.read(saved_.history);
  reader.read(saved_.sleeping);
  reader.read(saved_.fixtures);
  read_as_many(reader, loaded_held_J_, driven_.size());
  if (!reader.is_at_end()) throw std::invalid_argument("the block goes on behind its end");
  sleep_.check(sleep);
  listing_.check(saved_, is_stale);
  sleep_.load(sleep);
  adopt_sleep();
  listing_.load(saved_);
  if (!is_stale) adopt_listing();
  std::swap(state_, loaded_);
  std::swap(held_J_, loaded_held_J_);
  is_stale_ = is_stale;
}

}  // namespace stillgrid::dynamics
