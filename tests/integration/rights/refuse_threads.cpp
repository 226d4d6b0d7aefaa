// Loaded before a program (LD_PRELOAD), it lets it make as many threads as STILLGRID_TEST_THREADS
// says, and no more.

#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>

// The name, arguments and answer of the system's own.
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes,
                              void* (*run)(void*), void* argument) {
  static std::atomic<int> made = 0;
  static const int most = std::atoi(std::getenv("STILLGRID_TEST_THREADS"));
  static const auto real =
      reinterpret_cast<decltype(&pthread_create)>(dlsym(RTLD_NEXT, "pthread_create"));
  return made++ < most ? real(thread, attributes, run, argument) : EAGAIN;
}
