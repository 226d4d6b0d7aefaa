#include "shared/local/given_state.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "proto/scene_segment.hpp"
#include "shared/dynamics/byte_block.hpp"

namespace stillgrid::local {
namespace {

constexpr std::uint64_t kFormat = 0x32'6e65766967'6773;  // "sggiven2"; counts up with the layout
constexpr double kLightest = 1e12;                       // response to a force: a speck of 1e-12 kg
constexpr double kRounding = 1e-6;                       // of a response
constexpr std::size_t kBodyBytes = 8 + (3 + 6 + 6 + 36 + 6 + 1) * 8, kSphereBytes = 3 * 8 + 4 * 8;
constexpr std::size_t kProxyBytes = 8 + 3 * 3 * 8;

class Writer : public dynamics::BlockWriter {
 public:
  using BlockWriter::BlockWriter;
  template <class Vector>
  void each(const Vector& values) {
    for (const double x : values.reshaped()) add(x);
  }
};

/// Reads numbers within a bound; is_right() tells whether all were.
class Reader : public dynamics::BlockReader {
 public:
  using BlockReader::BlockReader;
  [[nodiscard]] double real(double largest = proto::kLargestNumber) {
    const auto x = number<double>();
    is_right_ = is_right_ && std::abs(x) <= largest;
    return x;
  }
  /// A whole number below `end`.
  [[nodiscard]] std::uint32_t index(std::uint64_t end) {
    const auto x = number<std::uint64_t>();
    is_right_ = is_right_ && x < end;
    return static_cast<std::uint32_t>(x);
  }
  template <class Vector>
  void each(Vector&& values, double largest = proto::kLargestNumber) {
    for (double& x : values.reshaped()) x = real(largest);
  }
  [[nodiscard]] bool is_right() const { return is_right_; }

 private:
  bool is_right_ = true;
};

std::size_t tool_spheres(const GivenModel& model) {
  std::size_t count = 0;
  for (const GivenModel::Tool& tool : model.tools) count += tool.spheres.size();
  return count;
}

bool read(Reader& reader, const GivenModel& model, GivenState& state) {
  constexpr std::uint64_t kNumbers = std::uint64_t{1} << 32U;
  const std::uint64_t bodies = reader.count(kBodyBytes);
  if (bodies > kMaxGivenBodies) return false;
  for (std::uint64_t i = 0; i < bodies; ++i) {
    GivenBody& body = state.bodies.emplace_back();
    body.number = reader.index(kNumbers);
    reader.each(body.centre_m);
    reader.each(body.twist);
    reader.each(body.acceleration, kLightest);
    reader.each(body.inverse_inertia, kLightest);
    reader.each(body.push);
    body.resisted = reader.real(1.0);
    const bool is_next = i == 0 || state.bodies[i - 1].number < body.number;
    if (!is_next || !reader.is_right() || !(body.resisted >= 0.0) ||
        !is_inverse_inertia(body.inverse_inertia))
      return false;
  }
  const std::uint64_t spheres = reader.count(kSphereBytes);
  if (spheres > kMaxGivenSpheres) return false;
  for (std::uint64_t i = 0; i < spheres; ++i) {
    GivenSphere& sphere = state.spheres.emplace_back();
    sphere.body = reader.index(bodies);
    sphere.number = reader.index(kNumbers);
    sphere.material = reader.index(model.materials.size());
    sphere.radius_m = reader.real();
    reader.each(sphere.arm_m);
    const bool is_next =
        i == 0 || std::pair(state.spheres[i - 1].body, state.spheres[i - 1].number) <
                      std::pair(sphere.body, sphere.number);
    if (!is_next || !(sphere.radius_m > 0.0) || !reader.is_right()) return false;
  }
  const std::uint64_t proxies = reader.count(kProxyBytes);
  if (proxies != 0 && proxies != tool_spheres(model)) return false;
  for (std::uint64_t i = 0; i < proxies; ++i) {
    GivenProxy& proxy = state.proxies.emplace_back();
    proxy.is_here = reader.index(2) == 1;
    for (Eigen::Vector3d* place : {&proxy.position_m, &proxy.stretch_m, &proxy.device_m})
      reader.each(*place);
    if (!reader.is_right()) return false;
  }
  return reader.is_at_end();
}

void require(bool is_right) {
  if (!is_right) throw std::invalid_argument("no model of given bodies");
}

}  // namespace

std::size_t given_state_capacity(std::size_t moving_count) noexcept {
  return 24 + std::min(kMaxGivenBodies, moving_count) * kBodyBytes +
         std::min(kMaxGivenSpheres, moving_count) * kSphereBytes + kMaxGivenProxies * kProxyBytes;
}

bool is_inverse_inertia(const Matrix6& matrix) noexcept {
  constexpr double kSmallest = 1e-9;  // of its block's largest: what is less is rounding
  // Written so that a NaN does not pass.
  if (!(matrix.cwiseAbs().maxCoeff() <= kLightest) || matrix.hasNaN()) return false;
  Twist own = matrix.diagonal();
  for (auto block : {own.head<3>(), own.tail<3>()})
    block = block.cwiseMax(kSmallest * block.maxCoeff());
  if (own.minCoeff() < 0.0) return false;
  Twist unit;  // in which each diagonal entry is 1 at most
  for (int i = 0; i < 6; ++i) unit[i] = own[i] > 0.0 ? 1.0 / std::sqrt(own[i]) : 0.0;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < i; ++j) {
      const double largest = std::sqrt(own[i]) * std::sqrt(own[j]);
      if (std::abs(matrix(i, j)) > (1.0 + kRounding) * largest ||
          std::abs(matrix(i, j) - matrix(j, i)) > kRounding * largest)
        return false;
    }
  const Matrix6 scaled = unit.asDiagonal() * matrix * unit.asDiagonal();
  const Eigen::LLT<Matrix6> factor(scaled + kRounding * Matrix6::Identity());
  return factor.info() == Eigen::Success;
}

std::vector<std::byte> encode(const GivenModel& model) {
  std::vector<std::byte> bytes;
  Writer writer(bytes);
  writer.add(kFormat);
  writer.add(model.period_ticks);
  writer.add<std::uint64_t>(model.materials.size());
  for (const collision::ContactMaterial& m : model.materials)
    for (const double x : {m.stiffness_N_per_m, m.damping_N_s_per_m, m.friction, m.slip_speed_m_s})
      writer.add(x);
  writer.add<std::uint64_t>(model.tools.size());
  for (const GivenModel::Tool& tool : model.tools) {
    writer.add<std::uint64_t>(tool.spheres.size());
    for (const GivenModel::ToolSphere& sphere : tool.spheres) {
      writer.each(sphere.centre_m);
      writer.add(sphere.radius_m);
    }
  }
  return bytes;
}

bool is_given_model(std::span<const std::byte> bytes) noexcept {
  std::uint64_t format = 0;
  if (bytes.size() < sizeof format) return false;
  std::memcpy(&format, bytes.data(), sizeof format);
  return format == kFormat;
}

GivenModel decode_given_model(std::span<const std::byte> bytes) {
  Reader reader(bytes);
  require(reader.number<std::uint64_t>() == kFormat);
  GivenModel model;
  model.period_ticks = reader.number<std::uint64_t>();
  require(model.period_ticks > 0 && model.period_ticks <= 100'000);
  model.materials.resize(reader.count(4 * 8));
  for (collision::ContactMaterial& m : model.materials) {
    for (double* x : {&m.stiffness_N_per_m, &m.damping_N_s_per_m, &m.friction, &m.slip_speed_m_s})
      require((*x = reader.real()) >= 0.0);
    require(m.slip_speed_m_s > 0.0);
  }
  model.tools.resize(reader.count(8));
  for (GivenModel::Tool& tool : model.tools) {
    tool.spheres.resize(reader.count(4 * 8));
    for (GivenModel::ToolSphere& sphere : tool.spheres) {
      reader.each(sphere.centre_m);
      require((sphere.radius_m = reader.real()) > 0.0);
    }
  }
  require(reader.is_right() && reader.is_at_end() && model.tools.size() <= proto::kMaxHands &&
          tool_spheres(model) <= kMaxGivenProxies);
  return model;
}

void encode(const GivenState& state, std::vector<std::byte>& bytes) {
  Writer writer(bytes);
  writer.add<std::uint64_t>(state.bodies.size());
  for (const GivenBody& body : state.bodies) {
    writer.add<std::uint64_t>(body.number);
    writer.each(body.centre_m);
    writer.each(body.twist);
    writer.each(body.acceleration);
    writer.each(body.inverse_inertia);
    writer.each(body.push);
    writer.add(body.resisted);
  }
  writer.add<std::uint64_t>(state.spheres.size());
  for (const GivenSphere& sphere : state.spheres) {
    for (const std::uint64_t x : {sphere.body, sphere.number, sphere.material}) writer.add(x);
    writer.add(sphere.radius_m);
    writer.each(sphere.arm_m);
  }
  writer.add<std::uint64_t>(state.proxies.size());
  for (const GivenProxy& proxy : state.proxies) {
    writer.add<std::uint64_t>(proxy.is_here ? 1 : 0);
    for (const Eigen::Vector3d* place : {&proxy.position_m, &proxy.stretch_m, &proxy.device_m})
      writer.each(*place);
  }
}

bool decode(std::span<const std::byte> bytes, const GivenModel& model, GivenState& state) {
  const auto clear = [&] {
    state.bodies.clear();
    state.spheres.clear();
    state.proxies.clear();
  };
  clear();
  bool is_right = false;
  try {
    Reader reader(bytes);
    is_right = read(reader, model, state);
  } catch (const std::invalid_argument&) {  // it ends too early
  }
  if (!is_right) clear();
  return is_right;
}

}  // namespace stillgrid::local
