#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

namespace stillgrid::devices {

/// The service is not there, has gone or does not answer, in one line.
class HaplyConnectionError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A WebSocket to the Haply Inverse Service. Used by one thread at a time.
class HaplyConnection {
 public:
  /// Connects and shakes hands, in 2 s at most. Throws HaplyConnectionError.
  HaplyConnection(const std::string& address, std::uint16_t port);

  /// Ends it as the protocol wants, in 100 ms at most.
  ~HaplyConnection();

  HaplyConnection(const HaplyConnection&) = delete;
  HaplyConnection& operator=(const HaplyConnection&) = delete;

  /// The next message, good until the next call. One that came while this process stood still is
  /// taken, however late. After a throw for want of time it may be called again.
  ///
  /// Throws HaplyConnectionError: nothing within the limit, a message above kMaxHaplyMessage, the
  /// end of the connection.
  [[nodiscard]] std::string_view receive(std::chrono::milliseconds limit);

  /// Throws HaplyConnectionError.
  void send(std::string_view text);

  /// Drops what has come since: the next that is received answers what is sent next. Throws
  /// HaplyConnectionError where messages come faster than they are dropped.
  void discard();

  /// The file of its socket, for a frame that somebody else sends.
  [[nodiscard]] int socket() const noexcept;

 private:
  struct Stream;
  std::unique_ptr<Stream> stream_;
};

}  // namespace stillgrid::devices
