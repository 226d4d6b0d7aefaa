#include "tests/soak/soak_state.hpp"

#include <sys/mman.h>

#include <cerrno>
#include <new>
#include <system_error>

namespace stillgrid::soak {

SharedSoakState::SharedSoakState() {
  void* const memory =
      ::mmap(nullptr, sizeof(SoakState), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED)
    throw std::system_error(errno, std::generic_category(), "no shared memory");
  state_ = new (memory) SoakState;
}

SharedSoakState::~SharedSoakState() {
  ::munmap(state_, sizeof(SoakState));
}

}  // namespace stillgrid::soak
