#include "tests/network/hostile_samples.hpp"

#include <cstring>
#include <limits>

namespace stillgrid::network {

using scene_relay::elements;
using scene_relay::point_to;

std::uint64_t HostileSamples::odd(std::uint64_t number) {
  constexpr std::uint64_t kLast = std::numeric_limits<std::uint64_t>::max();
  switch (random_() % 8) {
    case 0:
      return 0;
    case 1:
      return kLast;
    case 2:
      return kLast / 2 + random_() % 3;
    case 3:
      return number + random_() % 100;
    case 4:
      return number - random_() % 100;
    case 5:
      return number ^ (std::uint64_t{1} << random_() % 64);
    case 6:
      return random_();
    default:
      return number;
  }
}

template <class Plain>
void HostileSamples::scribble(Plain& plain) {
  static_assert(std::is_trivially_copyable_v<Plain>);
  constexpr float kNumbers[] = {0.0F,
                                -0.0F,
                                1e-30F,
                                -1e30F,
                                1e6F,
                                std::numeric_limits<float>::quiet_NaN(),
                                std::numeric_limits<float>::infinity(),
                                0.001F};
  auto* const bytes = reinterpret_cast<unsigned char*>(&plain);
  for (std::uint64_t i = random_() % 4; i > 0; --i) {
    const std::size_t at = random_() % (sizeof plain / 4) * 4;
    const auto any = static_cast<std::uint32_t>(random_());
    const void* from = happens(0.5) ? static_cast<const void*>(&any) : &kNumbers[random_() % 8];
    std::memcpy(bytes + at, from, 4);
  }
}

template <class Sequence, class Element>
void HostileSamples::change(Sequence& sequence, std::vector<Element>& own, std::size_t most) {
  const auto told = elements(sequence);
  own.assign(told.begin(), told.end());
  if (happens(0.1)) own.resize(random_() % (most + 1));
  if constexpr (sizeof(Element) >= 4)
    for (Element& element : own)
      if (happens(0.05)) scribble(element);
  point_to(sequence, own);
}

void HostileSamples::change_bytes(std::vector<std::uint8_t>& bytes) {
  for (std::uint8_t& byte : bytes)
    if (happens(0.001)) byte = static_cast<std::uint8_t>(random_());
}

scene_relay::Status HostileSamples::changed(scene_relay::Status status) {
  for (std::uint64_t* word : {&status.number, &status.sent_ns, &status.echo_sent_ns,
                              &status.echo_received_ns, &status.received, &status.follows,
                              &status.segment_epoch, &status.scene_epoch, &status.keyframe_id})
    if (happens(0.3)) *word = odd(*word);
  return status;
}

const scene_relay::ToolMessage& HostileSamples::changed(const scene_relay::ToolMessage& tool) {
  tool_message_ = tool;
  for (std::uint64_t* word :
       {&tool_message_.number, &tool_message_.segment_epoch, &tool_message_.period_ns,
        &tool_message_.time_ns, &tool_message_.tick, &tool_message_.path_number})
    if (happens(0.2)) *word = odd(*word);
  if (happens(0.2)) scribble(tool_message_.position_m);
  if (happens(0.2)) scribble(tool_message_.orientation_xyzw);
  if (happens(0.2)) scribble(tool_message_.velocity_m_s);
  if (happens(0.2)) scribble(tool_message_.force_N);
  if (happens(0.2)) scribble(tool_message_.torque_N_m);
  if (happens(0.2)) scribble(tool_message_.flags);
  if (happens(0.2)) tool_message_.position_m[random_() % 3] = 4.0 * uniform_(random_) - 2.0;
  tool_message_.is_led_on = happens(0.1);
  change(tool_message_.path, path_, 64);
  for (scene_relay::PathSample& sample : path_)
    if (happens(0.02)) sample.number = odd(sample.number);
  return tool_message_;
}

const scene_relay::SceneMessage& HostileSamples::changed(const scene_relay::SceneMessage& scene) {
  scene_ = scene;
  for (std::uint64_t* word : {&scene_.scene_epoch, &scene_.period_ns})
    if (happens(0.3)) *word = odd(*word);
  if (happens(0.2)) scene_.moving_capacity = static_cast<std::uint32_t>(odd(scene.moving_capacity));
  if (happens(0.2)) scribble(scene_.device_position_m);
  if (happens(0.2)) scribble(scene_.device_orientation_xyzw);
  if (happens(0.2)) scribble(scene_.device_scale);
  change(scene_.materials, materials_);
  change(scene_.planes, planes_);
  change(scene_.tool, tool_);
  change(scene_.spheres, spheres_);
  change(scene_.field_bodies, bodies_);
  change(scene_.model, model_);
  change_bytes(model_);
  if (happens(0.2)) scene_.state_capacity = odd(scene.state_capacity);
  if (happens(0.2)) scene_.hand = static_cast<std::uint32_t>(random_() % 5);
  return scene_;
}

const scene_relay::SnapshotMessage& HostileSamples::changed(
    const scene_relay::SnapshotMessage& snapshot) {
  snapshot_ = snapshot;
  for (std::uint64_t* word :
       {&snapshot_.number, &snapshot_.scene_epoch, &snapshot_.snapshot_id, &snapshot_.against_id,
        &snapshot_.state_time_ns, &snapshot_.publish_time_ns, &snapshot_.tool_time_ns,
        &snapshot_.step_ns, &snapshot_.contacts, &snapshot_.state_tick, &snapshot_.state_hash})
    if (happens(0.1)) *word = odd(*word);
  if (happens(0.2)) scribble(snapshot_.tool_work_J);
  if (happens(0.1)) snapshot_.sphere_count = static_cast<std::uint32_t>(random_());
  change(snapshot_.moved, moved_);
  change(snapshot_.motions, motions_);
  change(snapshot_.relabelled, relabelled_);
  change(snapshot_.labels, labels_);
  change(snapshot_.fields, fields_);
  change(snapshot_.state, state_);
  change_bytes(state_);
  return snapshot_;
}

}  // namespace stillgrid::network
