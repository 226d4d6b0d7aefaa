#pragma once

#include <httplib.h>

#include <atomic>

namespace stillgrid {

/// An HTTP server whose threads no client holds for long: a request has 2 s to come and its answer
/// 5 s to be taken, however slowly the bytes go. httplib's own limits are from byte to byte, so
/// that a slow client would hold a thread, and the server's end, for as long as it likes. Answers
/// are not compressed, whatever a client accepts.
class PromptServer final : public httplib::Server {
 public:
  /// As stop(), and ends all connections within 50 ms.
  void end();

 private:
  bool process_and_close_socket(socket_t socket) override;

  std::atomic<bool> ending_ = false;
};

}  // namespace stillgrid
