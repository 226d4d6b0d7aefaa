#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace stillgrid::dynamics {
class Integrator;
class NonlinearSolver;
}  // namespace stillgrid::dynamics

namespace stillgrid::scene {

struct Method;

/// What an integrator asks of a scene file, and of memory.
enum class IntegratorFamily {
  kExplicit,         // solves nothing, and is stable only below a step of its own
  kImplicitStage,    // its equations are solved by a NonlinearSolver
  kErrorControlled,  // divides a step by its error, and solves by itself
};

/// How velocities and positions are moved on in time. Two of one name are one.
struct IntegratorKind {
  std::string_view name;  // in scene files and reports
  IntegratorFamily family;
  /// Null: one of those below, which make_integrator() knows.
  std::unique_ptr<dynamics::Integrator> (*make)(const Method& method) = nullptr;

  static const IntegratorKind kSymplecticEuler;  // velocities first, positions by the new ones
  static const IntegratorKind kVelocityVerlet;   // the same, with half of the first and last force
  static const IntegratorKind kImplicitEuler;
  static const IntegratorKind kBdf2;
  static const IntegratorKind kTrapezoid;
  static const IntegratorKind kCvodeBdf;  // SUNDIALS: variable order and step

  friend constexpr bool operator==(const IntegratorKind& a, const IntegratorKind& b) {
    return a.name == b.name;
  }
};
inline constexpr IntegratorKind IntegratorKind::kSymplecticEuler{"symplectic_euler",
                                                                 IntegratorFamily::kExplicit};
inline constexpr IntegratorKind IntegratorKind::kVelocityVerlet{"velocity_verlet",
                                                                IntegratorFamily::kExplicit};
inline constexpr IntegratorKind IntegratorKind::kImplicitEuler{"implicit_euler",
                                                               IntegratorFamily::kImplicitStage};
inline constexpr IntegratorKind IntegratorKind::kBdf2{"bdf2", IntegratorFamily::kImplicitStage};
inline constexpr IntegratorKind IntegratorKind::kTrapezoid{"trapezoid",
                                                           IntegratorFamily::kImplicitStage};
inline constexpr IntegratorKind IntegratorKind::kCvodeBdf{"cvode_bdf",
                                                          IntegratorFamily::kErrorControlled};

/// What solves the equations of an implicit stage. Two of one name are one.
struct SolverKind {
  std::string_view name;  // in scene files and reports
  bool factorises;        // a matrix, whose factors take memory
  /// Null: one of those below, all Newton's method. tolerance: of the scaled residual, rms.
  std::unique_ptr<dynamics::NonlinearSolver> (*make)(double tolerance) = nullptr;

  static const SolverKind kNewton;    // symmetric blocks, projected where they are not definite;
                                      // sparse Cholesky
  static const SolverKind kNewtonLu;  // exact Jacobian, sparse LU
  static const SolverKind kNewtonCg;  // as newton, matrix-free: conjugate gradients
  static const SolverKind kNewtonBicgstab;  // exact Jacobian, matrix-free: BiCGSTAB

  friend constexpr bool operator==(const SolverKind& a, const SolverKind& b) {
    return a.name == b.name;
  }
};
inline constexpr SolverKind SolverKind::kNewton{"newton", true};
inline constexpr SolverKind SolverKind::kNewtonLu{"newton_lu", true};
inline constexpr SolverKind SolverKind::kNewtonCg{"newton_cg", false};
inline constexpr SolverKind SolverKind::kNewtonBicgstab{"newton_bicgstab", false};

/// The methods that a scene file may name.
struct MethodTable {
  std::span<const IntegratorKind> integrators;
  std::span<const SolverKind> solvers;  // the first where a scene names none
};
inline constexpr std::array kIntegrators = {
    IntegratorKind::kSymplecticEuler, IntegratorKind::kVelocityVerlet,
    IntegratorKind::kImplicitEuler,   IntegratorKind::kBdf2,
    IntegratorKind::kTrapezoid,       IntegratorKind::kCvodeBdf};
inline constexpr std::array kSolvers = {SolverKind::kNewton, SolverKind::kNewtonLu,
                                        SolverKind::kNewtonCg, SolverKind::kNewtonBicgstab};
/// What sim_server offers; the laboratory adds those that are measured beside.
inline constexpr MethodTable kMethods{kIntegrators, kSolvers};

/// Their names, in their order.
template <class Kind>
[[nodiscard]] std::vector<std::string_view> names_of(std::span<const Kind> kinds) {
  std::vector<std::string_view> names;
  for (const Kind& kind : kinds) names.push_back(kind.name);
  return names;
}

/// How a scene is integrated.
struct Method {
  IntegratorKind integrator = IntegratorKind::kImplicitEuler;
  SolverKind solver = SolverKind::kNewton;  // of an implicit stage only
  int substeps = 0;  // of a step, all alike; 0: explicit: as many as stability asks, implicit: 1
  double tolerance_m_s = 1e-8;  // what a solver leaves of a velocity's error, rms; SUNDIALS'
                                // integrators: a step's error of velocities, and relative

  bool operator==(const Method&) const = default;
};

[[nodiscard]] constexpr std::string_view name_of(const IntegratorKind& kind) {
  return kind.name;
}
[[nodiscard]] constexpr std::string_view name_of(const SolverKind& kind) {
  return kind.name;
}
/// These divide a step themselves, by its error.
[[nodiscard]] constexpr bool chooses_steps(const IntegratorKind& kind) {
  return kind.family == IntegratorFamily::kErrorControlled;
}
/// Explicit methods need no solver and are stable only below a step of their own.
[[nodiscard]] constexpr bool is_explicit(const IntegratorKind& kind) {
  return kind.family == IntegratorFamily::kExplicit;
}
/// Implicit methods, whose equations a NonlinearSolver solves.
[[nodiscard]] constexpr bool needs_solver(const IntegratorKind& kind) {
  return kind.family == IntegratorFamily::kImplicitStage;
}
/// Whether steps of this method factorise a matrix.
[[nodiscard]] constexpr bool factorises(const Method& method) {
  return needs_solver(method.integrator) && method.solver.factorises;
}

/// "symplectic_euler", "bdf2, newton_cg, 4 substeps": for reports.
[[nodiscard]] inline std::string describe(const Method& method) {
  std::string text(name_of(method.integrator));
  if (needs_solver(method.integrator)) text += ", " + std::string(name_of(method.solver));
  if (method.substeps > 1) text += ", " + std::to_string(method.substeps) + " substeps";
  return text;
}

}  // namespace stillgrid::scene
