#include "shared/tools/scene_relay/middleware_log.hpp"

#include <spdlog/spdlog.h>

#include <utility>

namespace stillgrid::scene_relay {
namespace {

/// Of its bytes those that a terminal shows, on one line that is not too long.
std::string shown(const char* text, std::size_t size) {
  constexpr std::size_t kLongest = 300;
  std::string line;
  for (std::size_t i = 0; i < size && text[i] != '\0' && line.size() < kLongest; ++i) {
    const char c = text[i] >= ' ' && text[i] <= '~' ? text[i] : ' ';
    if (c != ' ' || (!line.empty() && line.back() != ' ')) line += c;
  }
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

}  // namespace

MiddlewareLog::MiddlewareLog() {
  dds_set_log_sink(write, this);
}

MiddlewareLog::~MiddlewareLog() {
  dds_set_log_sink(nullptr, nullptr);
}

void MiddlewareLog::write(void* log, const dds_log_data_t* data) {
  static_cast<MiddlewareLog*>(log)->add(shown(data->message, data->size));
}

void MiddlewareLog::add(std::string line) {
  const std::lock_guard lock(mutex_);
  last_ = std::move(line);
  if (!is_told_ || count_ > kMax) return;
  if (++count_ <= kMax)
    spdlog::warn("DDS: " + last_);
  else
    spdlog::warn("DDS says more of the kind, which is not told");
}

void MiddlewareLog::tell() {
  const std::lock_guard lock(mutex_);
  is_told_ = true;
}

std::string MiddlewareLog::last() const {
  const std::lock_guard lock(mutex_);
  return last_;
}

}  // namespace stillgrid::scene_relay
