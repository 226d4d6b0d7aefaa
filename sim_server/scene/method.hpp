#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace stillgrid {

/// How velocities and positions are moved on in time.
enum class IntegratorKind {
  kForwardEuler,     // explicit; kept to show where it fails
  kSymplecticEuler,  // explicit: velocities first, positions by the new velocities
  kVelocityVerlet,   // explicit: the same, with half of the first and of the last force
  kImplicitEuler,
  kBdf2,
  kTrapezoid,
  kCvodeBdf,    // SUNDIALS: variable order and step
  kArkodeDirk,  // SUNDIALS: diagonally implicit Runge-Kutta of order 4
};
inline constexpr std::array<std::string_view, 8> kIntegratorNames = {
    "forward_euler", "symplectic_euler", "velocity_verlet", "implicit_euler",
    "bdf2",          "trapezoid",        "cvode_bdf",       "arkode_dirk"};

/// What solves the equations of an implicit step of ours.
enum class SolverKind {
  kNewton,              // symmetric blocks, projected where they are not definite; sparse Cholesky
  kNewtonLu,            // exact Jacobian, sparse LU
  kNewtonCg,            // as newton, matrix-free: conjugate gradients
  kNewtonBicgstab,      // exact Jacobian, matrix-free: BiCGSTAB
  kBroyden,             // from the Jacobian at the step's start
  kBroydenMass,         // from the mass matrix: the paper's
  kKinsolNewtonKrylov,  // SUNDIALS: GMRES
  kKinsolAnderson,      // SUNDIALS: accelerated fixed point
};
inline constexpr std::array<std::string_view, 8> kSolverNames = {"newton",
                                                                 "newton_lu",
                                                                 "newton_cg",
                                                                 "newton_bicgstab",
                                                                 "broyden",
                                                                 "broyden_mass",
                                                                 "kinsol_newton_krylov",
                                                                 "kinsol_anderson"};

/// How a scene is integrated.
struct Method {
  IntegratorKind integrator = IntegratorKind::kImplicitEuler;
  SolverKind solver = SolverKind::kNewton;  // implicit steps of ours only
  int substeps = 0;  // of a step, all alike; 0: explicit: as many as stability asks, implicit: 1
  double tolerance_m_s = 1e-8;  // what a solver leaves of a velocity's error, rms; SUNDIALS'
                                // integrators: a step's error of velocities, and relative

  bool operator==(const Method&) const = default;
};

[[nodiscard]] constexpr std::string_view name_of(IntegratorKind kind) {
  return kIntegratorNames[static_cast<std::size_t>(kind)];
}
[[nodiscard]] constexpr std::string_view name_of(SolverKind kind) {
  return kSolverNames[static_cast<std::size_t>(kind)];
}
/// These divide a step themselves, by its error.
[[nodiscard]] constexpr bool chooses_steps(IntegratorKind kind) {
  return kind == IntegratorKind::kCvodeBdf || kind == IntegratorKind::kArkodeDirk;
}
/// Explicit methods need no solver and are stable only below a step of their own.
[[nodiscard]] constexpr bool is_explicit(IntegratorKind kind) {
  return kind == IntegratorKind::kForwardEuler || kind == IntegratorKind::kSymplecticEuler ||
         kind == IntegratorKind::kVelocityVerlet;
}

/// Implicit methods of ours, whose equations one of our solvers solves.
[[nodiscard]] constexpr bool needs_solver(IntegratorKind kind) {
  return kind == IntegratorKind::kImplicitEuler || kind == IntegratorKind::kBdf2 ||
         kind == IntegratorKind::kTrapezoid;
}

/// "symplectic_euler", "bdf2, newton_cg, 4 substeps": for reports.
[[nodiscard]] inline std::string describe(const Method& method) {
  std::string text(name_of(method.integrator));
  if (needs_solver(method.integrator)) text += ", " + std::string(name_of(method.solver));
  if (method.substeps > 1) text += ", " + std::to_string(method.substeps) + " substeps";
  return text;
}

}  // namespace stillgrid
