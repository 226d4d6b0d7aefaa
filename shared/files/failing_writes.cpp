#include "shared/files/failing_writes.hpp"

#include <csignal>

namespace stillgrid::files {

void make_writes_fail() {
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
}

}  // namespace stillgrid::files
