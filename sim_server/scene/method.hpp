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

/// What an integrator asks of a scene file, and of memory.
enum class IntegratorFamily {
  kExplicit,         // solves nothing, and is stable only below a step of its own
  kImplicitStage,    // its equations are solved by one of our solvers
  kErrorControlled,  // divides a step by its error, and solves by itself
};
struct IntegratorEntry {
  std::string_view name;  // in scene files and reports
  IntegratorFamily family;
};
/// In the order of IntegratorKind.
inline constexpr auto kIntegrators =
    std::to_array<IntegratorEntry>({{"forward_euler", IntegratorFamily::kExplicit},
                                    {"symplectic_euler", IntegratorFamily::kExplicit},
                                    {"velocity_verlet", IntegratorFamily::kExplicit},
                                    {"implicit_euler", IntegratorFamily::kImplicitStage},
                                    {"bdf2", IntegratorFamily::kImplicitStage},
                                    {"trapezoid", IntegratorFamily::kImplicitStage},
                                    {"cvode_bdf", IntegratorFamily::kErrorControlled},
                                    {"arkode_dirk", IntegratorFamily::kErrorControlled}});

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

struct SolverEntry {
  std::string_view name;  // in scene files and reports
  bool factorises;        // a matrix, whose factors take memory
};
/// In the order of SolverKind.
inline constexpr auto kSolvers = std::to_array<SolverEntry>({{"newton", true},
                                                             {"newton_lu", true},
                                                             {"newton_cg", false},
                                                             {"newton_bicgstab", false},
                                                             {"broyden", true},
                                                             {"broyden_mass", false},
                                                             {"kinsol_newton_krylov", false},
                                                             {"kinsol_anderson", false}});

/// The names of a table, in its order.
template <class Entry, std::size_t kCount>
[[nodiscard]] constexpr std::array<std::string_view, kCount> names_of(
    const std::array<Entry, kCount>& table) {
  std::array<std::string_view, kCount> names;
  for (std::size_t i = 0; i < kCount; ++i) names[i] = table[i].name;
  return names;
}
inline constexpr auto kIntegratorNames = names_of(kIntegrators);
inline constexpr auto kSolverNames = names_of(kSolvers);

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
[[nodiscard]] constexpr IntegratorFamily family_of(IntegratorKind kind) {
  return kIntegrators[static_cast<std::size_t>(kind)].family;
}
/// These divide a step themselves, by its error.
[[nodiscard]] constexpr bool chooses_steps(IntegratorKind kind) {
  return family_of(kind) == IntegratorFamily::kErrorControlled;
}
/// Explicit methods need no solver and are stable only below a step of their own.
[[nodiscard]] constexpr bool is_explicit(IntegratorKind kind) {
  return family_of(kind) == IntegratorFamily::kExplicit;
}
/// Implicit methods of ours, whose equations one of our solvers solves.
[[nodiscard]] constexpr bool needs_solver(IntegratorKind kind) {
  return family_of(kind) == IntegratorFamily::kImplicitStage;
}
/// Whether steps of this method factorise a matrix.
[[nodiscard]] constexpr bool factorises(const Method& method) {
  return needs_solver(method.integrator) &&
         kSolvers[static_cast<std::size_t>(method.solver)].factorises;
}

/// "symplectic_euler", "bdf2, newton_cg, 4 substeps": for reports.
[[nodiscard]] inline std::string describe(const Method& method) {
  std::string text(name_of(method.integrator));
  if (needs_solver(method.integrator)) text += ", " + std::string(name_of(method.solver));
  if (method.substeps > 1) text += ", " + std::to_string(method.substeps) + " substeps";
  return text;
}

}  // namespace stillgrid
