#include "shared/viewer/prompt_server.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>

namespace stillgrid {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kIdle{2000};     // a connection that is kept, between two requests
constexpr milliseconds kRequest{2000};  // from its first byte to its last
constexpr milliseconds kAnswer{5000};   // likewise
constexpr int kLook_ms = 50;            // how often the server's end is looked for

/// A connection with a deadline for all that it does, not for each byte.
class PromptStream final : public httplib::Stream {
 public:
  PromptStream(socket_t socket, const std::atomic<bool>& ending)
      : socket_(socket), ending_(ending) {}

  /// Whether a request begins to come in time.
  [[nodiscard]] bool await_request() {
    deadline_ = Clock::now() + kIdle;
    const bool begins = begin_ < end_ || wait_for(POLLIN);
    deadline_ = Clock::now() + kRequest;
    answers_ = false;
    return begins;
  }

  [[nodiscard]] bool is_readable() const override { return begin_ < end_ || wait_for(POLLIN); }
  [[nodiscard]] bool is_writable() const override { return wait_for(POLLOUT); }

  ssize_t read(char* to, size_t size) override {
    if (begin_ == end_) {
      if (!wait_for(POLLIN)) return -1;
      const ssize_t got = ::recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
      if (got <= 0) return got;
      begin_ = 0;
      end_ = static_cast<std::size_t>(got);
    }
    const std::size_t taken = std::min(size, end_ - begin_);
    std::memcpy(to, buffer_.data() + begin_, taken);
    begin_ += taken;
    return static_cast<ssize_t>(taken);
  }

  ssize_t write(const char* from, size_t size) override {
    if (!answers_) deadline_ = Clock::now() + kAnswer;
    answers_ = true;
    if (!wait_for(POLLOUT)) return -1;
    return ::send(socket_, from, size, MSG_DONTWAIT | MSG_NOSIGNAL);
  }

  // All are of this machine, and nobody asks which.
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  [[nodiscard]] socket_t socket() const override { return socket_; }

 private:
  [[nodiscard]] bool wait_for(short event) const {
    while (!ending_ && Clock::now() < deadline_) {
      pollfd one{.fd = socket_, .events = event, .revents = 0};
      if (::poll(&one, 1, kLook_ms) > 0) return true;
    }
    return false;
  }

  socket_t socket_;
  const std::atomic<bool>& ending_;
  Clock::time_point deadline_;
  bool answers_ = false;
  std::array<char, 4096> buffer_{};
  std::size_t begin_ = 0, end_ = 0;  // of what was received and not read yet
};

/// Compression would be most of the time that an answer takes: 3 s of a processor for three.js.
void refuse_compression(httplib::Request& request) {
  request.headers.erase("Accept-Encoding");
}

}  // namespace

void PromptServer::end() {
  ending_ = true;
  stop();
}

bool PromptServer::process_and_close_socket(socket_t socket) {
  PromptStream stream(socket, ending_);
  bool is_kept = true;
  while (is_kept && stream.await_request()) {
    bool is_closed = false;
    is_kept = process_request(stream, false, is_closed, refuse_compression) && !is_closed;
  }
  ::shutdown(socket, SHUT_RDWR);
  ::close(socket);
  return true;
}

}  // namespace stillgrid
