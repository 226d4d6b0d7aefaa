#include "haptic_server/devices/spacemouse_client.hpp"

#include <poll.h>
#include <pthread.h>
#include <spnav.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <ctime>

namespace stillgrid::devices {
namespace {

/// While it lives this thread and those it starts take no signals; one of a broken pipe is lost.
class SignalsBlocked {
 public:
  SignalsBlocked() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before_);
  }
  ~SignalsBlocked() {
    // libspnav writes to a daemon that may just have gone, which must not end the server.
    sigset_t broken_pipe;
    sigemptyset(&broken_pipe);
    sigaddset(&broken_pipe, SIGPIPE);
    const timespec at_once{};
    while (sigtimedwait(&broken_pipe, nullptr, &at_once) == -1 && errno == EINTR) {
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  SignalsBlocked(const SignalsBlocked&) = delete;
  SignalsBlocked& operator=(const SignalsBlocked&) = delete;

 private:
  sigset_t before_{};
};

std::atomic<bool> is_taken = false;  // libspnav has one connection, whoever asks

bool has_hung_up(int socket) {
  char byte = 0;
  return recv(socket, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

}  // namespace

SpacemouseClient::Connection::Connection() {
  if (is_taken.exchange(true)) {
    throw DriverError(STILLGRID_DEVICE_E_NO_DEVICE,
                      "already in use by this program: expected one SpaceMouse");
  }
  const SignalsBlocked blocked;
  if (spnav_open() != 0) {
    is_taken = false;
    throw DriverError(STILLGRID_DEVICE_E_NO_DEVICE,
                      "no answer from spacenavd: expected it to run and its socket to be "
                      "$SPNAV_SOCKET, that of /etc/spnavrc or /var/run/spnav.sock");
  }
}

SpacemouseClient::Connection::~Connection() {
  spnav_close();
  is_taken = false;
}

SpacemouseClient::StopEvent::StopEvent() : file(eventfd(0, EFD_CLOEXEC)) {
  if (file == -1)
    throw DriverError(STILLGRID_DEVICE_E_IO, "too many open files: expected two more");
}

SpacemouseClient::StopEvent::~StopEvent() {
  close(file);
}

SpacemouseClient::SpacemouseClient(const HostLog& log) : log_(log) {
  const SignalsBlocked blocked;
  thread_ = std::thread([this] { run(); });
}

SpacemouseClient::~SpacemouseClient() {
  const std::uint64_t one = 1;
  // The counter cannot be full, and there is nothing else that a write to it can meet.
  while (write(stop_.file, &one, sizeof one) == -1 && errno == EINTR) {
  }
  thread_.join();
}

std::array<int, 6> SpacemouseClient::counts() const noexcept {
  std::array<int, 6> newest{};
  for (std::size_t axis = 0; axis < newest.size(); ++axis) {
    newest[axis] = counts_[axis].load(std::memory_order_relaxed);
  }
  return newest;
}

void SpacemouseClient::run() {
  pthread_setname_np(pthread_self(), "spacemouse");
  std::array<pollfd, 2> watched = {pollfd{spnav_fd(), POLLIN, 0}, pollfd{stop_.file, POLLIN, 0}};
  while (true) {
    if (poll(watched.data(), watched.size(), -1) == -1) continue;  // EINTR: nothing else is left
    if (watched[1].revents != 0) return;
    if (has_hung_up(watched[0].fd) || (watched[0].revents & (POLLERR | POLLNVAL)) != 0) {
      let_go();
      is_connected_.store(false, std::memory_order_release);
      log_.warn("spacenavd has gone: the tool stands still");
      return;
    }
    take_event();
  }
}

void SpacemouseClient::take_event() {
  spnav_event event{};
  switch (spnav_wait_event(&event)) {
    case SPNAV_EVENT_MOTION: {
      const std::array shown = {event.motion.x,  event.motion.y,  event.motion.z,
                                event.motion.rx, event.motion.ry, event.motion.rz};
      for (std::size_t axis = 0; axis < shown.size(); ++axis) {
        counts_[axis].store(shown[axis], std::memory_order_relaxed);
      }
      break;
    }
    case SPNAV_EVENT_BUTTON: {
      if (event.button.bnum < 0 || event.button.bnum >= 32) break;
      const std::uint32_t bit = 1U << static_cast<unsigned>(event.button.bnum);
      const std::uint32_t down = buttons_.load(std::memory_order_relaxed);
      buttons_.store(event.button.press != 0 ? down | bit : down & ~bit, std::memory_order_release);
      break;
    }
    case SPNAV_EVENT_DEV:
      if (event.dev.op != SPNAV_DEV_RM) break;
      let_go();
      log_.warn("the SpaceMouse was unplugged: the tool stands still");
      break;
    default:  // settings of the daemon's, or what a newer one sends
      break;
  }
}

void SpacemouseClient::let_go() noexcept {
  for (std::atomic<int>& count : counts_) count.store(0, std::memory_order_relaxed);
  buttons_.store(0, std::memory_order_release);
}

}  // namespace stillgrid::devices
