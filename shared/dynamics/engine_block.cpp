// The whole state of an engine as one block of bytes.
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <type_traits>

#include "shared/dynamics/engine.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr std::uint64_t kFormat = 0x33'6b636f6c62'6773;  // "sgblock3"; counts up with the layout

template <class T>
std::span<const std::byte> bytes_of(const T* values, std::size_t count) {
  static_assert(std::is_trivially_copyable_v<T>);
  return std::as_bytes(std::span(values, count));
}

class Writer {
 public:
  explicit Writer(std::vector<std::byte>& block) : block_(block) { block_.clear(); }
  void add(std::uint64_t number) { append(bytes_of(&number, 1)); }
  void add_rate(double rate) { append(bytes_of(&rate, 1)); }
  template <class T>
  void add(const std::vector<T>& values) {
    add(values.size());
    append(bytes_of(values.data(), values.size()));
  }

 private:
  void append(std::span<const std::byte> bytes) {
    if (bytes.empty()) return;
    const std::size_t size = block_.size();
    block_.resize(size + bytes.size());
    std::memcpy(block_.data() + size, bytes.data(), bytes.size());
  }
  std::vector<std::byte>& block_;
};

class Reader {
 public:
  explicit Reader(std::span<const std::byte> block) : left_(block) {}
  std::uint64_t number() {
    std::uint64_t value = 0;
    take(&value, 1);
    return value;
  }
  double rate() {
    double value = 0.0;
    take(&value, 1);
    if (!(value >= 0.0) || !std::isfinite(value))
      throw std::invalid_argument("the block has a rate that is not a positive number");
    return value;
  }
  template <class T>
  void read(std::vector<T>& values) {
    const std::uint64_t count = number();
    if (count > left_.size() / sizeof(T)) throw std::invalid_argument("the block ends too early");
    values.resize(count);
    take(values.data(), count);
  }
  template <class T>
  void read_as_many(std::vector<T>& values, std::size_t count) {
    read(values);
    if (values.size() != count)
      throw std::invalid_argument("the block is of a scene of other bodies");
  }
  [[nodiscard]] bool is_at_end() const { return left_.empty(); }

 private:
  template <class T>
  void take(T* values, std::size_t count) {
    const std::size_t size = count * sizeof(T);
    if (size > left_.size()) throw std::invalid_argument("the block ends too early");
    if (size > 0) std::memcpy(static_cast<void*>(values), left_.data(), size);
    left_ = left_.subspan(size);
  }
  std::span<const std::byte> left_;
};

/// Calls visit(array) for all arrays of nodes, then for all of rigid bodies.
template <class State, class Nodes, class Rigid>
void each_array(State& state, const Nodes& nodes, const Rigid& rigid) {
  nodes(state.node_position_m);
  nodes(state.node_velocity_m_s);
  rigid(state.rigid_position_m);
  rigid(state.rigid_velocity_m_s);
  rigid(state.orientation);
  rigid(state.angular_velocity_rad_s);
  rigid(state.is_here);
}

}  // namespace

void Engine::save(std::vector<std::byte>& block) const {
  Writer writer(block);
  const auto add = [&](const auto& values) { writer.add(values); };
  writer.add(kFormat);
  writer.add(fingerprint_);
  writer.add(state_.tick);
  writer.add_rate(state_.contacts.stiffness_per_s2);
  writer.add_rate(state_.contacts.damping_per_s);
  writer.add(is_stale_ ? 1 : 0);
  each_array(state_, add, add);
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
}

void Engine::load(std::span<const std::byte> block) {
  Reader reader(block);
  if (reader.number() != kFormat)
    throw std::invalid_argument("the block is not of this version of the engine");
  if (reader.number() != fingerprint_) throw std::invalid_argument("the block is of another scene");
  SceneState state;
  state.tick = reader.number();
  state.contacts = {reader.rate(), reader.rate()};
  const bool is_stale = reader.number() != 0;
  each_array(
      state, [&](auto& values) { reader.read_as_many(values, description_.nodes.size()); },
      [&](auto& values) { reader.read_as_many(values, description_.rigid_bodies.size()); });
  Sleep::Saved sleep;
  reader.read_as_many(sleep.rested_s, description_.bodies.size());
  reader.read_as_many(sleep.island, description_.bodies.size());
  reader.read(saved_.base);
  reader.read(saved_.order);
  reader.read(saved_.groups);
  reader.read(saved_.sphere_a);
  reader.read(saved_.sphere_b);
  reader.read(saved_.field_base);
  reader.read(saved_.history);
  reader.read(saved_.sleeping);
  if (!reader.is_at_end()) throw std::invalid_argument("the block goes on behind its end");
  sleep_.check(sleep);
  listing_.check(saved_, is_stale);
  sleep_.load(sleep);
  adopt_sleep();
  listing_.load(saved_);
  if (!is_stale) adopt_listing();
  state_ = std::move(state);
  is_stale_ = is_stale;
}

}  // namespace stillgrid::dynamics
