#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/scene_segment.hpp"
#include "shared/collision/contact_law.hpp"

namespace stillgrid::local {

using Twist = Eigen::Matrix<double, 6, 1>;    // also a wrench: at a centre, and about it
using Matrix6 = Eigen::Matrix<double, 6, 6>;  // inverse inertia: 1/kg, 1/(kg m), 1/(kg m^2)

/// The tools and materials of a scene of given bodies.
struct GivenModel {
  struct ToolSphere {
    Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  // in the tool's frame
    double radius_m = 0.0;
  };
  struct Tool {
    std::vector<ToolSphere> spheres;
  };
  std::uint64_t period_ticks = 1;  // one publication, rounded up
  std::vector<collision::ContactMaterial> materials;
  std::vector<Tool> tools;  // one a hand
};

/// A rigid body as its publisher gives it. It moves on under the acceleration and the tools'
/// pushes. All in the frame of the world, at the body's centre.
struct GivenBody {
  std::uint32_t number = 0;  // the publisher's
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Twist twist = Twist::Zero();         // m/s, rad/s
  Twist acceleration = Twist::Zero();  // all but the tools', m/s^2, rad/s^2
  Matrix6 inverse_inertia = Matrix6::Zero();
  Twist push = Twist::Zero();  // mean wrench of the tools in the last step, N, N m
  double resisted = 0.0;       // share of it that something else took, as a floor does, 0 to 1
};

/// A sphere of a given body.
struct GivenSphere {
  std::uint32_t body = 0;    // index among the state's bodies
  std::uint32_t number = 0;  // the publisher's
  std::uint32_t material = 0;
  double radius_m = 0.0;
  Eigen::Vector3d arm_m = Eigen::Vector3d::Zero();    // its place beside the body's centre
  Eigen::Vector3d own_m_s = Eigen::Vector3d::Zero();  // beside the body's twist; not encoded
};

/// The proxy of a tool's sphere: see rendering::ToolProxies.
struct GivenProxy {
  bool is_here = false;  // the tool was there; else the rest is unset
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d stretch_m = Eigen::Vector3d::Zero();  // that of friction
  Eigen::Vector3d device_m = Eigen::Vector3d::Zero();   // the tool's sphere
  // The rest is not encoded.
  bool is_let_out = false;  // it is new, and a surface around it still lets it out
  Eigen::Vector3d from_m = Eigen::Vector3d::Zero();  // the tool's sphere a tick before
  static constexpr std::uint32_t kNone = UINT32_MAX;
  std::uint32_t carrier = kNone;                    // number of the sphere that pushes it most
  std::uint32_t carrier_body = kNone;               // number of its body
  Eigen::Vector3d arm_m = Eigen::Vector3d::Zero();  // its place beside that sphere's centre
};

/// The bodies near the tools at one moment. Bodies are in the order of their numbers,
/// spheres in that of their bodies, then of their own numbers.
struct GivenState {
  std::vector<GivenBody> bodies;
  std::vector<GivenSphere> spheres;
  std::vector<GivenProxy> proxies;  // in the order of hands and their spheres, or empty
};

/// Bodies that one state encodes, and bodies and spheres that a copy has room for.
inline constexpr std::size_t kMaxGivenBodies = 64, kMaxHeldBodies = 512, kMaxGivenSpheres = 2048;

/// Proxies that one state encodes.
inline constexpr std::size_t kMaxGivenProxies = proto::kMaxHands * proto::kMaxToolSpheres;

/// Bytes of the largest state of a scene of so many spheres, a multiple of 8.
[[nodiscard]] std::size_t given_state_capacity(std::size_t moving_count) noexcept;

/// Whether a matrix of numbers up to 1e12 is symmetric to rounding and has no eigenvalue below 0
/// but for rounding: 1e-6 of its diagonal. Realtime: yes.
[[nodiscard]] bool is_inverse_inertia(const Matrix6& matrix) noexcept;

/// Returns the model as bytes. They begin otherwise than those of dynamics::encode().
[[nodiscard]] std::vector<std::byte> encode(const GivenModel& model);
/// Whether bytes begin as those of a GivenModel.
[[nodiscard]] bool is_given_model(std::span<const std::byte> bytes) noexcept;
/// Returns the model of encode()'s bytes. They may be hostile: it throws std::invalid_argument
/// where they hold no such model or a number that contradicts its meaning.
[[nodiscard]] GivenModel decode_given_model(std::span<const std::byte> bytes);

/// Writes a state as one block. Realtime: yes, where bytes has given_state_capacity().
/// Pre: kMaxGivenBodies, kMaxGivenSpheres and kMaxGivenProxies at most.
void encode(const GivenState& state, std::vector<std::byte>& bytes);
/// Reads encode()'s block, which may be hostile. Returns whether a publisher of that model may
/// write its counts, numbers, inverse inertias and order; else the state is empty. Realtime: yes,
/// where the state's vectors have room for kMaxGivenBodies, kMaxGivenSpheres and kMaxGivenProxies.
[[nodiscard]] bool decode(std::span<const std::byte> bytes, const GivenModel& model,
                          GivenState& state);

}  // namespace stillgrid::local
