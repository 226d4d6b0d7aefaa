#include "tests/network/relay/generated_snapshots.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "shared/tools/scene_relay/sequence.hpp"

namespace stillgrid::scene_relay {
namespace {

template <class T>
bool are_same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

template <class Sequence, class Element>
void keep(Sequence& sequence, std::vector<Element>& own) {
  const auto told = elements(sequence);
  own.assign(told.begin(), told.end());
  point_to(sequence, own);
}

}  // namespace

GeneratedSnapshots::GeneratedSnapshots(std::uint32_t seed, Going going, std::uint32_t spheres,
                                       std::uint64_t period_ns)
    : random_(seed), going_(going), capacity_(spheres), period_ns_(period_ns) {
  begin_anew();
}

Motion GeneratedSnapshots::motion() {
  Motion motion{};
  for (auto* numbers : {motion.position_m, motion.velocity_m_s})
    for (int axis = 0; axis < 3; ++axis) numbers[axis] = number(-0.7F, 0.9F);
  return motion;
}

Label GeneratedSnapshots::label() {
  const std::uint32_t material = static_cast<std::uint32_t>(random_() % 3);
  return {number(0.003F, 0.041F), material == 2 ? proto::kFieldPoint : material,
          static_cast<std::uint32_t>(random_() % 17)};
}

FieldMotion GeneratedSnapshots::field() {
  FieldMotion field{};
  double norm2 = 0.0;
  for (float& x : field.orientation_xyzw) x = number(-1.0F, 1.1F);
  for (const float x : field.orientation_xyzw) norm2 += double{x} * double{x};
  for (float& x : field.orientation_xyzw) x /= static_cast<float>(std::sqrt(norm2));
  for (auto* numbers : {field.position_m, field.velocity_m_s, field.angular_velocity_rad_s})
    for (int axis = 0; axis < 3; ++axis) numbers[axis] = number(-0.3F, 0.4F);
  return field;
}

/// The snapshot's state: of any length, and at times none.
void GeneratedSnapshots::go_on() {
  snapshot_.state_tick = snapshot_.state_time_ns / 1'000'000;
  snapshot_.state_hash = (std::uint64_t{random_()} << 32U) + random_();
  snapshot_.state.resize(is_one_of(0.1) ? 0 : random_() % (kStateCapacity + 1));
  for (std::uint8_t& byte : snapshot_.state) byte = static_cast<std::uint8_t>(random_());
}

void GeneratedSnapshots::begin_anew() {
  snapshot_ = {};
  snapshot_.state_time_ns = 77'000'000'003;
  const std::uint32_t count = going_ == Going::kComeAndGo ? capacity_ / 2 : capacity_;
  for (std::uint32_t i = 0; i < count; ++i) {
    snapshot_.motions.push_back(motion());
    snapshot_.labels.push_back(label());
  }
  snapshot_.fields = {field(), field()};
}

const ToldSnapshot& GeneratedSnapshots::next() {
  ++snapshot_.snapshot_id;
  snapshot_.state_time_ns += period_ns_;
  snapshot_.publish_time_ns = snapshot_.state_time_ns + random_() % 1'300'000;
  snapshot_.tool_time_ns = is_one_of(0.1) ? 0 : snapshot_.state_time_ns - 4'321'987;
  snapshot_.step_ns = random_() % 9'999'999;
  snapshot_.contacts = random_() % 13;
  snapshot_.tool_work_J += static_cast<double>(number(-0.01F, 0.02F));
  go_on();
  if (going_ == Going::kAtRest) return snapshot_;
  const double share = going_ == Going::kAllMove ? 1.0 : 0.05;
  for (Motion& of : snapshot_.motions)
    if (is_one_of(share)) of = motion();
  if (going_ == Going::kRelabelled)
    for (Label& of : snapshot_.labels)
      if (is_one_of(0.03)) of = label();
  if (going_ == Going::kComeAndGo && is_one_of(0.3)) {
    const std::size_t count = random_() % (capacity_ + 1);
    snapshot_.motions.resize(std::min(count, snapshot_.motions.size()));
    snapshot_.labels.resize(snapshot_.motions.size());
    while (snapshot_.motions.size() < count && is_one_of(0.99)) {
      snapshot_.motions.push_back(motion());
      snapshot_.labels.push_back(label());
    }
  }
  snapshot_.fields[random_() % 2] = field();
  return snapshot_;
}

bool are_same(const ToldSnapshot& a, const ToldSnapshot& b) {
  return a.snapshot_id == b.snapshot_id && a.state_time_ns == b.state_time_ns &&
         a.publish_time_ns == b.publish_time_ns && a.tool_time_ns == b.tool_time_ns &&
         a.step_ns == b.step_ns && a.contacts == b.contacts && a.state_tick == b.state_tick &&
         a.state_hash == b.state_hash && a.tool_work_J == b.tool_work_J &&
         are_same_bits(a.motions, b.motions) && are_same_bits(a.labels, b.labels) &&
         are_same_bits(a.state, b.state) && are_same_bits(a.fields, b.fields);
}

KeptMessage::KeptMessage(const SnapshotMessage& message) : message_(message) {
  keep(message_.moved, moved_);
  keep(message_.relabelled, relabelled_);
  keep(message_.motions, motions_);
  keep(message_.labels, labels_);
  keep(message_.fields, fields_);
  keep(message_.state, state_);
}

}  // namespace stillgrid::scene_relay
