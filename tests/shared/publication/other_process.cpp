#include "tests/shared/publication/other_process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

namespace stillgrid::publication {

OtherProcess::OtherProcess(const std::function<void(const Ready&)>& work) {
  std::array<int, 2> pipe{};
  if (::pipe2(pipe.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  pid_ = ::fork();
  if (pid_ < 0) throw std::runtime_error("no process");
  if (pid_ == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    try {
      work([&] {
        if (::write(pipe[1], "r", 1) != 1) ::_exit(1);
      });
    } catch (...) {
    }
    ::_exit(1);  // without the test program's own end
  }
  ::close(pipe[1]);
  char said = 0;
  was_ready_ = ::read(pipe[0], &said, 1) == 1;
  ::close(pipe[0]);
}

void OtherProcess::kill() {
  if (pid_ < 0) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

void OtherProcess::rest() {
  for (;;) ::pause();
}

}  // namespace stillgrid::publication
