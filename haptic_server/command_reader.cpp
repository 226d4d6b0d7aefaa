#include "haptic_server/command_reader.hpp"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace stillgrid::haptic_server {
namespace {

constexpr std::size_t kLongestLine = 1024;
/// Refusals that are told, a line each.
constexpr std::uint64_t kMaxTold = 20;
constexpr auto kPoll = std::chrono::milliseconds(20);

/// For people: what is no printable character of ASCII is '?'.
std::string printable(std::string_view text) {
  std::string line(text.substr(0, 80));
  for (char& c : line)
    if (c < ' ' || c > '~') c = '?';
  return line;
}

}  // namespace

CommandReader::CommandReader(const std::filesystem::path& file, device::Device& device,
                             ToolOrders& tool)
    : device_(device),
      tool_(tool),
      name_(file.string()),
      file_(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {
  if (file_ < 0)
    throw std::runtime_error("--commands: value '" + name_ +
                             "': expected a file that can be read: " + std::strerror(errno));
  struct stat is {};
  if (::fstat(file_, &is) != 0 || S_ISDIR(is.st_mode)) {
    ::close(file_);
    throw std::runtime_error("--commands: value '" + name_ +
                             "': expected a file or a named pipe, not a folder");
  }
  is_file_ = S_ISREG(is.st_mode);
  thread_ = std::jthread([this](const std::stop_token& end) { read_lines(end); });
}

CommandReader::~CommandReader() {
  thread_.request_stop();
  thread_.join();
  ::close(file_);
  if (refusals_ > kMaxTold)
    spdlog::warn("{} commands were refused, {} of them not told", refusals_, refusals_ - kMaxTold);
}

/// Nothing more is there. The last line of a file that does not grow is a line; what a writer of a
/// pipe left unfinished is none of the next one's.
void CommandReader::take_end(bool may_obey) {
  if (!may_obey || pending_.empty()) return;
  if (!std::exchange(was_at_end_, true)) return;
  if (is_file_)
    obey(pending_);
  else
    refuse(pending_, "its writer left before the end of the line");
  pending_.clear();
}

void CommandReader::read_lines(const std::stop_token& end) {
  std::array<char, 4096> part{};
  while (!end.stop_requested()) {
    const bool may_obey = device_.is_active();  // else they wait, as for a device that is lost
    const ssize_t count = may_obey ? ::read(file_, part.data(), part.size()) : 0;
    if (count <= 0) {  // a pipe without a writer is at its end, until the next one comes
      take_end(may_obey && count == 0);
      std::this_thread::sleep_for(kPoll);
      continue;
    }
    was_at_end_ = false;
    for (const char c : std::string_view(part.data(), static_cast<std::size_t>(count))) {
      if (c != '\n') {
        if (pending_.size() <= kLongestLine) pending_ += c;
        continue;
      }
      obey(pending_);
      pending_.clear();
    }
  }
}

void CommandReader::obey(const std::string& line) {
  const std::size_t equals = line.find('=');
  const bool is_order = line.size() <= kLongestLine && equals != std::string::npos && equals > 0 &&
                        line.find('\0') == std::string::npos;
  const auto give = [&](const std::string& key, const std::string& value) {
    return key.starts_with("tool.") ? tool_.obey(key, value) : device_.command(key, value);
  };
  const std::string refusal = is_order ? give(line.substr(0, equals), line.substr(equals + 1))
                                       : "expected KEY=VALUE, at most 1024 characters";
  if (refusal.empty())
    spdlog::info("command {}", printable(line));
  else
    refuse(line, refusal);
}

void CommandReader::refuse(const std::string& line, const std::string& why) {
  if (++refusals_ <= kMaxTold) spdlog::warn("command '{}': {}", printable(line), why);
}

}  // namespace stillgrid::haptic_server
