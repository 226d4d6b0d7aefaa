#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <cstddef>
#include <list>
#include <memory>
#include <optional>
#include <string>

#include "shared/tools/scene_viewer/page_answers.hpp"

namespace stillgrid::scene_viewer {

class PageConnection;

/// All connections: strangers in the order in which they came, and apart from them, by their last
/// request, those that have shown the key; so strangers, however many, end one another and not
/// them.
struct ConnectionLists {
  static constexpr std::size_t kMaxStrangers = 256;  // whose first request has not come yet
  static constexpr std::size_t kMaxKnown = 16;       // a browser opens six
  std::list<PageConnection*> strangers, known;
};

/// One connection: a request after the other, with bodies of 1 KiB at most. It holds at most
/// 17 KiB of what comes, 2 s of waiting for it, and 5 s of taking an answer, however slowly the
/// bytes go; of fields it looks at Host, Origin and Connection alone, so there are no ranges and
/// nothing is compressed. Thread: one, for all of them.
class PageConnection : public std::enable_shared_from_this<PageConnection> {
 public:
  /// Pre: answer and lists outlive it. Ends the oldest connection where there are too many.
  PageConnection(boost::asio::ip::tcp::socket&& socket, const AnswerPage& answer,
                 ConnectionLists& lists);
  ~PageConnection();
  PageConnection(const PageConnection&) = delete;
  PageConnection& operator=(const PageConnection&) = delete;
  PageConnection(PageConnection&&) = delete;
  PageConnection& operator=(PageConnection&&) = delete;

  /// Waits for the first request.
  void start() { read(); }

 private:
  void read();
  void take_request(boost::beast::error_code error);
  void write(const PageAnswer& answer, bool without_body, bool is_last);
  void befriend();
  void end();

  boost::beast::tcp_stream stream_;
  boost::beast::flat_buffer received_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::string_body>> parser_;
  std::string head_;  // of the answer under way
  Message body_;
  const AnswerPage& answer_;
  ConnectionLists& lists_;
  std::list<PageConnection*>* list_;  // null: ended for another one
  std::list<PageConnection*>::iterator place_;
};

}  // namespace stillgrid::scene_viewer
