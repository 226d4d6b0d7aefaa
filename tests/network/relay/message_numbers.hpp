#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "shared/tools/scene_relay/messages.hpp"

namespace stillgrid::scene_relay {

/// Takes every number of a message by its name: real ones, and those that say which.
struct NumberVisitor {
  std::function<void(const std::string&, float&)> real32;
  std::function<void(const std::string&, double&)> real64;
  std::function<void(const std::string&, std::uint32_t&)> index;

  template <std::size_t N>
  void all(const std::string& name, float (&numbers)[N]) const {
    for (std::size_t i = 0; i < N; ++i) real32(name + "[" + std::to_string(i) + "]", numbers[i]);
  }
  template <std::size_t N>
  void all(const std::string& name, double (&numbers)[N]) const {
    for (std::size_t i = 0; i < N; ++i) real64(name + "[" + std::to_string(i) + "]", numbers[i]);
  }
  void some(const std::string& name, dds_sequence_float& numbers) const {
    for (std::uint32_t i = 0; i < numbers._length; i += 1 + numbers._length / 13)
      real32(name + "[" + std::to_string(i) + "]", numbers._buffer[i]);
  }
};

template <class Sequence>
auto mutable_elements(Sequence& sequence) {
  return std::span(sequence._buffer, sequence._length);
}

inline void visit(const NumberVisitor& v, const std::string& name,
                  stillgrid_relay3_FieldState& state) {
  v.all(name + ".position_m", state.position_m);
  v.all(name + ".orientation_xyzw", state.orientation_xyzw);
  v.all(name + ".velocity_m_s", state.velocity_m_s);
  v.all(name + ".angular_velocity_rad_s", state.angular_velocity_rad_s);
}

inline void visit(const NumberVisitor& v, SceneMessage& message) {
  v.real32("tool_slip_speed_m_s", message.tool_slip_speed_m_s);
  v.all("device_position_m", message.device_position_m);
  v.all("device_orientation_xyzw", message.device_orientation_xyzw);
  v.real64("device_scale", message.device_scale);
  for (auto& m : mutable_elements(message.materials)) {
    v.real32("stiffness_N_per_m", m.stiffness_N_per_m);
    v.real32("damping_N_s_per_m", m.damping_N_s_per_m);
    v.real32("friction", m.friction);
    v.real32("slip_speed_m_s", m.slip_speed_m_s);
  }
  for (auto& p : mutable_elements(message.planes)) {
    v.all("normal", p.normal);
    v.real32("offset_m", p.offset_m);
    v.index("plane's material", p.material);
  }
  for (auto& s : mutable_elements(message.tool)) {
    v.all("tool's position_m", s.position_m);
    v.real32("tool's radius_m", s.radius_m);
  }
  for (auto& s : mutable_elements(message.spheres)) {
    v.all("sphere's position_m", s.position_m);
    v.real32("sphere's radius_m", s.radius_m);
    v.index("sphere's material", s.material);
  }
  for (auto& f : mutable_elements(message.fields)) {
    v.all("lowest_m", f.lowest_m);
    v.real32("brick_m", f.brick_m);
    for (std::uint32_t& bricks : f.bricks) v.index("bricks", bricks);
    v.all("centre_m", f.centre_m);
    v.real32("bounding_radius_m", f.bounding_radius_m);
    v.index("kind", f.kind);
    v.some("coarse", f.coarse);
    v.some("stiffness", f.stiffness);
    v.some("fine", f.fine);
    for (std::uint32_t& number : mutable_elements(f.numbers)) v.index("brick's number", number);
  }
  for (auto& b : mutable_elements(message.field_bodies)) {
    v.index("field", b.field);
    v.index("moving", b.moving);
    v.index("field's material", b.material);
    if (b.moving == 0) visit(v, "rest", b.rest);
  }
  v.index("hand", message.hand);
}

inline void visit(const NumberVisitor& v, SnapshotMessage& message) {
  v.real64("tool_work_J", message.tool_work_J);
  for (auto& m : mutable_elements(message.motions)) {
    v.all("position_m", m.position_m);
    v.all("velocity_m_s", m.velocity_m_s);
  }
  for (auto& l : mutable_elements(message.labels)) {
    v.real32("radius_m", l.radius_m);
    v.index("material", l.material);
  }
  for (auto& f : mutable_elements(message.fields)) visit(v, "field", f);
}

}  // namespace stillgrid::scene_relay
