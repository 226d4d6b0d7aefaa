#include <dlfcn.h>
#include <malloc.h>
#include <pthread.h>
#include <semaphore.h>
#include <spawn.h>

#include <cstdlib>

#include "shared/realtime/guard/violations.hpp"

// glibc's own allocator under names that nobody interposes.
extern "C" {
// NOLINTBEGIN(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp,readability-identifier-naming)
void* __libc_malloc(std::size_t size) noexcept;
void* __libc_calloc(std::size_t count, std::size_t size) noexcept;
void* __libc_realloc(void* memory, std::size_t size) noexcept;
void* __libc_memalign(std::size_t alignment, std::size_t size) noexcept;
void __libc_free(void* memory) noexcept;
// NOLINTEND(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp,readability-identifier-naming)
}

namespace stillgrid::realtime {
namespace {

/// The definition that this library hides. Asked for without a lock: libraries that start before
/// this one call it too.
template <class Function>
class Hidden {
 public:
  constexpr explicit Hidden(const char* name, const char* version = nullptr) noexcept
      : name_(name), version_(version) {}

  Function* get() noexcept {
    void* found = found_.load(std::memory_order_relaxed);
    if (found == nullptr) {
      found =
          version_ == nullptr ? ::dlsym(RTLD_NEXT, name_) : ::dlvsym(RTLD_NEXT, name_, version_);
      found_.store(found, std::memory_order_relaxed);
    }
    return reinterpret_cast<Function*>(found);
  }

 private:
  const char* name_;
  const char* version_;
  std::atomic<void*> found_ = nullptr;
};

}  // namespace
}  // namespace stillgrid::realtime

// NOLINTBEGIN(readability-inconsistent-declaration-parameter-name,bugprone-macro-parentheses)

#define STILLGRID_EXPORT extern "C" [[gnu::visibility("default")]]

// An int function that is noted and passed on; version: of the symbol, where there are two.
#define STILLGRID_INTERPOSE(name, parameters, arguments, may_throw, version)             \
  STILLGRID_EXPORT int name parameters may_throw {                                       \
    static constinit stillgrid::realtime::Violation violation(#name);                    \
    static constinit stillgrid::realtime::Hidden<int parameters> hidden(#name, version); \
    stillgrid::realtime::note(violation);                                                \
    return hidden.get() arguments;                                                       \
  }

STILLGRID_EXPORT void* malloc(std::size_t size) noexcept {
  static constinit stillgrid::realtime::Violation violation("malloc");
  stillgrid::realtime::note(violation);
  return __libc_malloc(size);
}
STILLGRID_EXPORT void* calloc(std::size_t count, std::size_t size) noexcept {
  static constinit stillgrid::realtime::Violation violation("calloc");
  stillgrid::realtime::note(violation);
  return __libc_calloc(count, size);
}
STILLGRID_EXPORT void* realloc(void* memory, std::size_t size) noexcept {
  static constinit stillgrid::realtime::Violation violation("realloc");
  stillgrid::realtime::note(violation);
  return __libc_realloc(memory, size);
}
STILLGRID_EXPORT void free(void* memory) noexcept {
  static constinit stillgrid::realtime::Violation violation("free");
  if (memory != nullptr) stillgrid::realtime::note(violation);
  __libc_free(memory);
}
STILLGRID_EXPORT void* memalign(std::size_t alignment, std::size_t size) noexcept {
  static constinit stillgrid::realtime::Violation violation("memalign");
  stillgrid::realtime::note(violation);
  return __libc_memalign(alignment, size);
}
STILLGRID_EXPORT void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  static constinit stillgrid::realtime::Violation violation("aligned_alloc");
  stillgrid::realtime::note(violation);
  return __libc_memalign(alignment, size);
}
STILLGRID_INTERPOSE(posix_memalign, (void** memory, std::size_t alignment, std::size_t size),
                    (memory, alignment, size), noexcept, nullptr)

STILLGRID_INTERPOSE(pthread_mutex_lock, (pthread_mutex_t * mutex), (mutex), noexcept, nullptr)
STILLGRID_INTERPOSE(pthread_mutex_trylock, (pthread_mutex_t * mutex), (mutex), noexcept, nullptr)
STILLGRID_INTERPOSE(pthread_mutex_timedlock, (pthread_mutex_t * mutex, const timespec* until),
                    (mutex, until), noexcept, nullptr)
STILLGRID_INTERPOSE(pthread_mutex_clocklock,
                    (pthread_mutex_t * mutex, clockid_t clock, const timespec* until),
                    (mutex, clock, until), noexcept, nullptr)

STILLGRID_INTERPOSE(pthread_rwlock_rdlock, (pthread_rwlock_t * lock), (lock), noexcept, nullptr)
STILLGRID_INTERPOSE(pthread_rwlock_tryrdlock, (pthread_rwlock_t * lock), (lock), noexcept, nullptr)
STILLGRID_INTERPOSE(pthread_rwlock_timedrdlock, (pthread_rwlock_t * lock, const timespec* until),
                    (lock, until), noexcept, nullptr)
STILLGRID_INTERPOSE(pthread_rwlock_clockrdlock,
                    (pthread_rwlock_t * lock, clockid_t clock, const timespec* until),
                    (lock, clock, until), noexcept, nullptr)
STILLGRID_INTERPOSE(pthread_rwlock_wrlock, (pthread_rwlock_t * lock), (lock), noexcept, nullptr)
STILLGRID_INTERPOSE(pthread_rwlock_trywrlock, (pthread_rwlock_t * lock), (lock), noexcept, nullptr)
STILLGRID_INTERPOSE(pthread_rwlock_timedwrlock, (pthread_rwlock_t * lock, const timespec* until),
                    (lock, until), noexcept, nullptr)
STILLGRID_INTERPOSE(pthread_rwlock_clockwrlock,
                    (pthread_rwlock_t * lock, clockid_t clock, const timespec* until),
                    (lock, clock, until), noexcept, nullptr)

// The older version of these two takes another layout of pthread_cond_t.
STILLGRID_INTERPOSE(pthread_cond_wait, (pthread_cond_t * condition, pthread_mutex_t* mutex),
                    (condition, mutex), , "GLIBC_2.3.2")
STILLGRID_INTERPOSE(pthread_cond_timedwait,
                    (pthread_cond_t * condition, pthread_mutex_t* mutex, const timespec* until),
                    (condition, mutex, until), , "GLIBC_2.3.2")
STILLGRID_INTERPOSE(pthread_cond_clockwait,
                    (pthread_cond_t * condition, pthread_mutex_t* mutex, clockid_t clock,
                     const timespec* until),
                    (condition, mutex, clock, until), , nullptr)

STILLGRID_INTERPOSE(sem_wait, (sem_t * semaphore), (semaphore), , nullptr)
STILLGRID_INTERPOSE(sem_timedwait, (sem_t * semaphore, const timespec* until), (semaphore, until), ,
                    nullptr)
STILLGRID_INTERPOSE(sem_clockwait, (sem_t * semaphore, clockid_t clock, const timespec* until),
                    (semaphore, clock, until), , nullptr)

// The filter cannot see into clone3, by which glibc starts threads and processes.
STILLGRID_INTERPOSE(pthread_create,
                    (pthread_t * thread, const pthread_attr_t* attributes, void* (*start)(void*),
                     void* argument),
                    (thread, attributes, start, argument), noexcept, nullptr)
STILLGRID_INTERPOSE(posix_spawn,
                    (pid_t * process, const char* file, const posix_spawn_file_actions_t* actions,
                     const posix_spawnattr_t* attributes, char* const arguments[],
                     char* const environment[]),
                    (process, file, actions, attributes, arguments, environment), , nullptr)
STILLGRID_INTERPOSE(posix_spawnp,
                    (pid_t * process, const char* file, const posix_spawn_file_actions_t* actions,
                     const posix_spawnattr_t* attributes, char* const arguments[],
                     char* const environment[]),
                    (process, file, actions, attributes, arguments, environment), , nullptr)

// NOLINTEND(readability-inconsistent-declaration-parameter-name,bugprone-macro-parentheses)
