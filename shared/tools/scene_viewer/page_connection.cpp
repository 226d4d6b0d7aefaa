#include "shared/tools/scene_viewer/page_connection.hpp"

#include <array>
#include <boost/asio/write.hpp>
#include <boost/beast/core/error.hpp>
#include <boost/beast/http/error.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/status.hpp>
#include <chrono>
#include <utility>

namespace stillgrid::scene_viewer {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using std::chrono::seconds;

constexpr seconds kRequest{2};  // from the end of the last answer to a request's last byte
constexpr seconds kAnswer{5};   // from an answer's first byte to its last
constexpr std::size_t kMaxHead = 8192;
constexpr std::size_t kMaxBody = 1024;
constexpr std::size_t kMaxReceived = 2 * kMaxHead;

/// The page may load and ask nothing but what is served here. The hash is of the import map in
/// index.html: where that has changed the browser's console tells the new one.
constexpr std::string_view kFixedFields =
    "Cache-Control: no-store\r\n"
    "X-Content-Type-Options: nosniff\r\n"
    "X-Frame-Options: DENY\r\n"
    "Referrer-Policy: no-referrer\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\n"
    "Content-Security-Policy: default-src 'self'; img-src 'self' data: blob:; "
    "script-src 'self' 'sha256-OuR7MxkUgGHhn7iWQtKCPA7WcP0m/Xm3MoeLpkpsgDg='\r\n";

std::string head_of(const PageAnswer& answer, bool is_last) {
  const auto reason = http::obsolete_reason(static_cast<http::status>(answer.status));
  std::string head = "HTTP/1.1 " + std::to_string(answer.status) + " ";
  head.append(reason.data(), reason.size());
  head += "\r\nContent-Type: " + answer.type +
          "\r\nContent-Length: " + std::to_string(answer.body->size()) + "\r\n";
  head += kFixedFields;
  if (is_last) head += "Connection: close\r\n";
  return head += "\r\n";
}

PageAnswer refusal_of(beast::error_code error) {
  const bool is_long = error == http::error::header_limit || error == http::error::buffer_overflow;
  const bool is_fat = error == http::error::body_limit;
  return {.status = is_long  ? 431U
                    : is_fat ? 413U
                             : 400U,
          .body = std::make_shared<const std::string>(is_long  ? "a request of 8 KiB at most\n"
                                                      : is_fat ? "a body of 1 KiB at most\n"
                                                               : "a request of HTTP/1.1\n"),
          .is_to_stranger = true};
}

std::string_view view_of(beast::string_view text) {
  return {text.data(), text.size()};
}

}  // namespace

PageConnection::PageConnection(asio::ip::tcp::socket&& socket, const AnswerPage& answer,
                               ConnectionLists& lists)
    : stream_(std::move(socket)),
      received_(kMaxReceived),
      answer_(answer),
      lists_(lists),
      list_(&lists.strangers) {
  if (list_->size() >= ConnectionLists::kMaxStrangers) list_->front()->end();
  place_ = list_->insert(list_->end(), this);
  beast::error_code ignored;
  stream_.socket().set_option(asio::ip::tcp::no_delay(true), ignored);
}

PageConnection::~PageConnection() {
  if (list_ != nullptr) list_->erase(place_);
}

void PageConnection::end() {
  list_->erase(place_);
  list_ = nullptr;
  stream_.close();
}

void PageConnection::befriend() {
  const bool is_new = list_ != &lists_.known;
  if (is_new && lists_.known.size() >= ConnectionLists::kMaxKnown) lists_.known.front()->end();
  lists_.known.splice(lists_.known.end(), *list_, place_);
  list_ = &lists_.known;
}

void PageConnection::read() {
  parser_.emplace();
  parser_->header_limit(kMaxHead);
  parser_->body_limit(kMaxBody);
  stream_.expires_after(kRequest);
  http::async_read(stream_, received_, *parser_,
                   [self = shared_from_this()](beast::error_code error, std::size_t) {
                     self->take_request(error);
                   });
}

void PageConnection::take_request(beast::error_code error) {
  if (list_ == nullptr) return;  // ended meanwhile
  // Errors of the parser alone are answered: with the others there is nobody to answer.
  if (error && error.category() != make_error_code(http::error::bad_method).category()) return;
  if (error == http::error::end_of_stream) return;
  if (error) return write(refusal_of(error), false, true);
  const auto& request = parser_->get();
  const PageAnswer answer = answer_({.method = view_of(request.method_string()),
                                     .target = view_of(request.target()),
                                     .host = view_of(request[http::field::host]),
                                     .origin = view_of(request[http::field::origin]),
                                     .body = request.body()});
  if (!answer.is_to_stranger) befriend();
  write(answer, request.method() == http::verb::head,
        answer.is_to_stranger || !request.keep_alive());
}

void PageConnection::write(const PageAnswer& answer, bool without_body, bool is_last) {
  head_ = head_of(answer, is_last);
  body_ = answer.body;
  const std::array<asio::const_buffer, 2> bytes = {
      asio::buffer(head_), asio::const_buffer(body_->data(), without_body ? 0 : body_->size())};
  stream_.expires_after(kAnswer);
  asio::async_write(
      stream_, bytes, [self = shared_from_this(), is_last](beast::error_code error, std::size_t) {
        self->body_.reset();
        if (!error && !is_last) return self->read();
        beast::error_code ignored;
        self->stream_.socket().shutdown(asio::ip::tcp::socket::shutdown_both, ignored);
      });
}

}  // namespace stillgrid::scene_viewer
