#include "haptic_server/devices/haply_connection.hpp"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>

#include "haptic_server/devices/haply_protocol.hpp"

namespace stillgrid::devices {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::ip::tcp;
using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kConnect{2000};
constexpr milliseconds kSend{50};
constexpr milliseconds kClose{100};
constexpr int kMaxUnasked = 100;  // at a time

/// What an operation came to.
struct Outcome {
  bool is_done = false;
  beast::error_code error;

  auto handler() {
    return [this](beast::error_code result, auto&&...) {
      error = result;
      is_done = true;
    };
  }
};

}  // namespace

struct HaplyConnection::Stream {
  asio::io_context events{1};
  beast::websocket::stream<tcp::socket> socket{events};
  beast::flat_buffer received{kMaxHaplyMessage};
  Outcome reading{true, {}};
  Outcome writing{true, {}};

  /// False where time is over first.
  bool wait(const Outcome& outcome, milliseconds limit) {
    const auto deadline = steady_clock::now() + limit;
    events.restart();  // it stops where nothing is left to do
    while (!outcome.is_done) {
      if (events.run_one_until(deadline) != 0) continue;
      events.poll();  // after a stall the time is over and the answer there
      if (!outcome.is_done) return false;
    }
    return true;
  }
  void read() {
    received.consume(received.size());
    reading = {};
    socket.async_read(received, reading.handler());
  }
  /// Throws where the connection has gone.
  static void require(const Outcome& outcome) {
    if (!outcome.error) return;
    if (outcome.error == beast::websocket::error::message_too_big ||
        outcome.error == beast::websocket::error::buffer_overflow)
      throw HaplyConnectionError("the service's message is longer than 64 KiB");
    throw HaplyConnectionError("the service has ended the connection (" + outcome.error.message() +
                               ")");
  }
};

HaplyConnection::HaplyConnection(const std::string& address, std::uint16_t port)
    : stream_(std::make_unique<Stream>()) {
  const std::string service = address + ":" + std::to_string(port);
  const auto absent = [&service](const std::string& reason) {
    return HaplyConnectionError("no answer from the Haply Inverse Service at " + service + " (" +
                                reason + "): expected it to run");
  };
  Stream& stream = *stream_;
  beast::error_code error;
  const asio::ip::address host = asio::ip::make_address(address, error);
  if (error) throw HaplyConnectionError("address " + address + ": expected numbers, as 127.0.0.1");
  Outcome connecting;
  stream.socket.next_layer().async_connect(tcp::endpoint(host, port), connecting.handler());
  const bool is_connected = stream.wait(connecting, kConnect);
  if (!is_connected || connecting.error) {
    stream.socket.next_layer().close(error);
    stream.events.poll();  // what is left of the operation ends while its outcome lives
    throw absent(is_connected ? connecting.error.message() : "2 s have passed");
  }
  stream.socket.next_layer().set_option(tcp::no_delay(true), error);
  stream.socket.read_message_max(0);  // at a limit of its own Beast closes: no zero could follow
  stream.socket.text(true);
  Outcome shaking;
  stream.socket.async_handshake(service, "/", shaking.handler());
  const bool is_done = stream.wait(shaking, kConnect);
  if (!is_done || shaking.error) {
    stream.socket.next_layer().close(error);
    stream.events.poll();
    throw absent(is_done ? shaking.error.message() : "no handshake within 2 s");
  }
}

HaplyConnection::~HaplyConnection() {
  Stream& stream = *stream_;
  beast::error_code ignored;
  try {
    if (stream.writing.is_done && stream.socket.is_open()) {
      Outcome closing;
      stream.socket.async_close(beast::websocket::close_code::normal, closing.handler());
      // What was sent last must arrive: closed with unread mail, a socket throws it away.
      const bool is_done = stream.wait(closing, kClose);
      stream.socket.next_layer().shutdown(tcp::socket::shutdown_both, ignored);
      stream.socket.next_layer().close(ignored);
      if (!is_done) stream.wait(closing, kClose);
    } else {
      stream.socket.next_layer().shutdown(tcp::socket::shutdown_both, ignored);
      stream.socket.next_layer().close(ignored);
    }
    stream.wait(stream.reading, kClose);
    stream.wait(stream.writing, kClose);
  } catch (...) {  // memory: the socket closes all the same
  }
}

std::string_view HaplyConnection::receive(milliseconds limit) {
  Stream& stream = *stream_;
  if (stream.reading.is_done) stream.read();
  if (!stream.wait(stream.reading, limit))
    throw HaplyConnectionError("the service has not answered for " + std::to_string(limit.count()) +
                               " ms");
  Stream::require(stream.reading);
  return {static_cast<const char*>(stream.received.data().data()), stream.received.size()};
}

void HaplyConnection::send(std::string_view text) {
  Stream& stream = *stream_;
  if (!stream.writing.is_done) throw HaplyConnectionError("the service takes no message");
  stream.writing = {};
  stream.socket.async_write(asio::buffer(text.data(), text.size()), stream.writing.handler());
  if (!stream.wait(stream.writing, kSend))
    throw HaplyConnectionError("the service takes no message");
  Stream::require(stream.writing);
}

void HaplyConnection::discard() {
  Stream& stream = *stream_;
  if (stream.reading.is_done) stream.read();
  for (int messages = 0;; ++messages) {
    stream.events.restart();
    stream.events.poll();
    if (!stream.reading.is_done) return;
    Stream::require(stream.reading);
    if (messages == kMaxUnasked)
      throw HaplyConnectionError("the service sends messages that nobody asked for");
    stream.read();
  }
}

int HaplyConnection::socket() const noexcept {
  return stream_->socket.next_layer().native_handle();
}

}  // namespace stillgrid::devices
