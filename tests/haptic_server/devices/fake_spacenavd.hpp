#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <thread>

namespace stillgrid::devices {

/// The socket of a daemon that speaks spacenavd's protocol: requests of four bytes and events of
/// eight 32-bit numbers [libspnav 1.0, proto.h]. $SPNAV_SOCKET names it while it lives.
class FakeSpacenavd {
 public:
  enum class Manners { kAnswers, kOld, kHangsUp };

  /// It meets one client: answers what version of the protocol it speaks, says nothing as daemons
  /// before that question did, or hangs up at once.
  explicit FakeSpacenavd(Manners manners = Manners::kAnswers)
      : path_(std::filesystem::temp_directory_path() /
              ("stillgrid_spnav_" + std::to_string(getpid()) + "_" + std::to_string(++daemons))),
        listener_(socket(AF_UNIX, SOCK_STREAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path_.c_str(), sizeof address.sun_path - 1);
    REQUIRE(bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    REQUIRE(listen(listener_, 1) == 0);
    setenv("SPNAV_SOCKET", path_.c_str(), 1);
    greeter_ = std::thread([this, manners] { greet(manners); });
  }
  ~FakeSpacenavd() {
    unsetenv("SPNAV_SOCKET");
    shutdown(listener_, SHUT_RDWR);
    hang_up();
    close(listener_);
    std::filesystem::remove(path_);
  }
  FakeSpacenavd(const FakeSpacenavd&) = delete;
  FakeSpacenavd& operator=(const FakeSpacenavd&) = delete;

  /// Sends one event to the client that has connected.
  void send_event(const std::array<std::int32_t, 8>& event) {
    if (greeter_.joinable()) greeter_.join();
    REQUIRE(send(client_, event.data(), sizeof event, MSG_NOSIGNAL) == sizeof event);
  }
  void motion(const std::array<std::int32_t, 6>& counts) {
    send_event({0, counts[0], counts[1], counts[2], counts[3], counts[4], counts[5], 16});
  }
  void button(std::int32_t number, bool is_down) { send_event({is_down ? 1 : 2, number}); }
  void unplug() { send_event({3, 1}); }

  void hang_up() {
    if (greeter_.joinable()) greeter_.join();
    if (client_ >= 0) close(client_);
    client_ = -1;
  }

 private:
  void greet(Manners manners) {
    client_ = accept(listener_, nullptr, nullptr);
    if (client_ < 0) return;
    if (manners == Manners::kHangsUp) {
      close(client_);
      client_ = -1;
    } else if (manners == Manners::kAnswers) {
      std::int32_t question = 0;
      if (recv(client_, &question, sizeof question, MSG_WAITALL) != sizeof question) return;
      send(client_, &question, sizeof question, MSG_NOSIGNAL);  // the version it asked for
    }
  }

  static inline int daemons = 0;
  std::filesystem::path path_;
  int listener_ = -1;
  int client_ = -1;
  std::thread greeter_;
};

}  // namespace stillgrid::devices
