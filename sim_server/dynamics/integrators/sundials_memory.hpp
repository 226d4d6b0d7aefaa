#pragma once

#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_linearsolver.h>

#include <Eigen/Core>
#include <memory>
#include <new>
#include <type_traits>

// Owners of what SUNDIALS allocates. For the two .cpp files that use SUNDIALS only.
namespace stillgrid::dynamics {

struct FreeSunContext {
  void operator()(SUNContext context) const { SUNContext_Free(&context); }
};
struct FreeSunVector {
  void operator()(N_Vector vector) const { N_VDestroy(vector); }
};
struct FreeSunLinearSolver {
  void operator()(SUNLinearSolver solver) const { SUNLinSolFree(solver); }
};
using SunContext = std::unique_ptr<std::remove_pointer_t<SUNContext>, FreeSunContext>;
using SunVector = std::unique_ptr<_generic_N_Vector, FreeSunVector>;
using SunLinearSolver = std::unique_ptr<_generic_SUNLinearSolver, FreeSunLinearSolver>;

/// Solvers' own memory comes as void*, freed through its address.
template <void (*kFree)(void**)>
struct FreeSunMemory {
  void operator()(void* memory) const { kFree(&memory); }
};
template <void (*kFree)(void**)>
using SunMemory = std::unique_ptr<void, FreeSunMemory<kFree>>;

/// Whatever SUNDIALS hands out is there, or memory is short.
template <class Pointer>
[[nodiscard]] Pointer sun_checked(Pointer pointer) {
  if (pointer == nullptr) throw std::bad_alloc();
  return pointer;
}

[[nodiscard]] inline SunContext make_sun_context() {
  SUNContext context = nullptr;
#if SUNDIALS_VERSION_MAJOR < 7
  SUNContext_Create(nullptr, &context);
#else
  SUNContext_Create(SUN_COMM_NULL, &context);
  SUNContext_ClearErrHandlers(sun_checked(context));
#endif
  return SunContext(sun_checked(context));
}

[[nodiscard]] inline SunVector make_sun_vector(Eigen::Index size, SUNContext context) {
  return SunVector(sun_checked(N_VNew_Serial(static_cast<sunindextype>(size), context)));
}

[[nodiscard]] inline Eigen::Map<Eigen::VectorXd> values_of(N_Vector vector) {
  return {NV_DATA_S(vector), NV_LENGTH_S(vector)};
}

/// Ignores an error message of SUNDIALS 6: reports state how a solve ended. In SUNDIALS 7 the
/// context prints errors, and ours has no handler.
inline void ignore_message(int, const char*, const char*, char*, void*) {}

/// What a callback answers: SUNDIALS tries again from nearer after a recoverable failure.
inline constexpr int kSunDone = 0, kSunRetry = 1, kSunStop = -1;

}  // namespace stillgrid::dynamics
