#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

namespace stillgrid::dynamics {
struct EngineMethod;
}  // namespace stillgrid::dynamics

namespace stillgrid::scene {

/// Groups integrators by the keys that a scene file may set beside them.
enum class IntegratorFamily {
  kExplicit,         // solves no equations; stable only below a step of its own
  kImplicit,         // solves the equations of each step
  kErrorControlled,  // chooses its own steps by their error
};

/// How velocities and positions advance in time. Two kinds with the same name are equal.
struct IntegratorKind {
  std::string_view name;  // in scene files and reports
  IntegratorFamily family;
  /// Returns the engine's method. Null for the integrators below, which the simulation knows.
  dynamics::EngineMethod (*method)(double tolerance_m_s) = nullptr;

  static const IntegratorKind kVelocityVerlet;
  static const IntegratorKind kImplicitEuler;  // by Newton's method with conjugate gradients
  static const IntegratorKind kCvodeBdf;       // SUNDIALS: variable order and step; the reference

  friend constexpr bool operator==(const IntegratorKind& a, const IntegratorKind& b) {
    return a.name == b.name;
  }
};
inline constexpr IntegratorKind IntegratorKind::kVelocityVerlet{"velocity_verlet",
                                                                IntegratorFamily::kExplicit};
inline constexpr IntegratorKind IntegratorKind::kImplicitEuler{"implicit_euler",
                                                               IntegratorFamily::kImplicit};
inline constexpr IntegratorKind IntegratorKind::kCvodeBdf{"cvode_bdf",
                                                          IntegratorFamily::kErrorControlled};

using Integrators = std::span<const IntegratorKind>;
/// The integrators that a scene file may name; the laboratory adds one that is measured beside.
inline constexpr std::array kIntegrators = {
    IntegratorKind::kVelocityVerlet, IntegratorKind::kImplicitEuler, IntegratorKind::kCvodeBdf};

/// How a scene is integrated.
struct Method {
  IntegratorKind integrator = IntegratorKind::kImplicitEuler;
  int substeps = 0;  // equal parts of a step; 0: as many as stability asks if explicit, else 1
  double tolerance_m_s = 1e-8;  // implicit: rms error of the velocities at which the solver stops;
                                // error controlled: error of each step, also relative

  bool operator==(const Method&) const = default;
};

[[nodiscard]] constexpr std::string_view name_of(const IntegratorKind& kind) {
  return kind.name;
}
[[nodiscard]] constexpr bool chooses_steps(const IntegratorKind& kind) {
  return kind.family == IntegratorFamily::kErrorControlled;
}
[[nodiscard]] constexpr bool is_explicit(const IntegratorKind& kind) {
  return kind.family == IntegratorFamily::kExplicit;
}
[[nodiscard]] constexpr bool is_implicit(const IntegratorKind& kind) {
  return kind.family == IntegratorFamily::kImplicit;
}

/// "velocity_verlet", "implicit_euler, 4 substeps": for reports.
[[nodiscard]] inline std::string describe(const Method& method) {
  std::string text(name_of(method.integrator));
  if (method.substeps > 1) text += ", " + std::to_string(method.substeps) + " substeps";
  return text;
}

}  // namespace stillgrid::scene
