#include "shared/tools/scene_viewer/page_server.hpp"

#include <spdlog/spdlog.h>
#include <sys/random.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <exception>
#include <stdexcept>
#include <thread>
#include <utility>

#include "shared/tools/scene_viewer/page_answers.hpp"
#include "shared/tools/scene_viewer/page_connection.hpp"

namespace stillgrid::scene_viewer {
namespace {

namespace asio = boost::asio;
using Tcp = asio::ip::tcp;
using Error = boost::system::error_code;

constexpr int kUsualPort = 8642;
constexpr std::chrono::milliseconds kPause{50};  // where the system gives no connection
constexpr std::chrono::milliseconds kTidy{250};

/// 128 bits from the system, in hexadecimal digits.
std::string random_key() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw std::runtime_error("the system gives no random numbers for the page's address");
  std::string key;
  for (const unsigned byte : bytes) {
    key += "0123456789abcdef"[byte >> 4U];
    key += "0123456789abcdef"[byte & 15U];
  }
  return key;
}

}  // namespace

struct PageServer::Server {
  std::string key = random_key();
  std::optional<PageAnswers> answers;
  AnswerPage answer;
  ConnectionLists lists;  // before the context, whose end ends the connections
  asio::io_context context{1};
  Tcp::acceptor acceptor{context};
  asio::steady_timer pause{context}, tidying{context};
  std::jthread thread;

  [[nodiscard]] Error bind(int port);
  void accept();
  void tidy();
};

Error PageServer::Server::bind(int port) {
  const Tcp::endpoint here(asio::ip::address_v4::loopback(), static_cast<unsigned short>(port));
  Error error;
  acceptor.open(here.protocol(), error);
  if (!error) acceptor.set_option(Tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(here, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) {
    Error ignored;
    acceptor.close(ignored);
  }
  return error;
}

void PageServer::Server::accept() {
  acceptor.async_accept([this](Error error, Tcp::socket socket) {
    if (!error) {
      std::make_shared<PageConnection>(std::move(socket), answer, lists)->start();
      return accept();
    }
    pause.expires_after(kPause);
    pause.async_wait([this](Error) { accept(); });
  });
}

/// Looks now and then for a page that is gone and holds a hand.
void PageServer::Server::tidy() {
  answers->drop_silent_hands();
  tidying.expires_after(kTidy);
  tidying.async_wait([this](Error) { tidy(); });
}

PageServer::PageServer(std::optional<int> port) : server_(std::make_unique<Server>()) {
  Error error = server_->bind(port.value_or(kUsualPort));
  if (error && !port) error = server_->bind(0);
  if (error)
    throw std::runtime_error(
        "--port: value " + std::to_string(port.value_or(0)) +
        ": expected a free port of this machine, or 0 for any: " + error.message());
}

PageServer::~PageServer() {
  server_->context.stop();
}

std::string PageServer::address() const {
  return "http://127.0.0.1:" + std::to_string(server_->acceptor.local_endpoint().port()) + "/" +
         server_->key + "/";
}

void PageServer::start(Views& views, const std::filesystem::path& page) {
  server_->answers.emplace(views, server_->key, page);
  server_->answer = [answers = &*server_->answers](const PageQuestion& question) {
    return answers->to(question);
  };
  server_->accept();
  server_->tidy();
  server_->thread = std::jthread([context = &server_->context] {
    while (!context->stopped()) try {
        context->run();
      } catch (const std::exception& error) {  // memory is short: that one connection has ended
        spdlog::warn("the page: {}", error.what());
      }
  });
}

}  // namespace stillgrid::scene_viewer
