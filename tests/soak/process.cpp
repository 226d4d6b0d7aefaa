#include "tests/soak/process.hpp"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <exception>
#include <system_error>

namespace stillgrid::soak {
namespace {

int exit_status(int wait_status) {
  return WIFEXITED(wait_status) ? WEXITSTATUS(wait_status) : 128 + WTERMSIG(wait_status);
}

}  // namespace

Process::Process(const std::function<void()>& work) : id_(::fork()) {
  if (id_ < 0) throw std::system_error(errno, std::generic_category(), "no process");
  if (id_ > 0) return;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  int status = 0;
  try {
    work();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "publication_soak: %s\n", error.what());
    status = 1;
  }
  ::_exit(status);  // without the parent's own end
}

std::optional<int> Process::status() {
  int wait_status = 0;
  if (!status_ && ::waitpid(id_, &wait_status, WNOHANG) == id_) status_ = exit_status(wait_status);
  return status_;
}

void Process::kill() {
  if (status_) return;
  ::kill(id_, SIGKILL);
  int wait_status = 0;
  ::waitpid(id_, &wait_status, 0);
  status_ = exit_status(wait_status);
}

}  // namespace stillgrid::soak
