#include "shared/tools/scene_viewer/view_file.hpp"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace stillgrid::scene_viewer {
namespace {

/// Opens the file: the name, the version, and bytes to come.
constexpr std::array<char, 16> kHead = {'S', 'T', 'L', 'G', 'V', 'I', 'E', 'W', 2};

struct RecordHead {
  ViewRecord kind;
  std::uint32_t bytes;
};

bool is_known(ViewRecord kind) {
  return kind == ViewRecord::kScene || kind == ViewRecord::kFrame || kind == ViewRecord::kTicks;
}

[[noreturn]] void fail_to_write(const std::filesystem::path& path) {
  throw std::runtime_error("--save: " + path.string() +
                           " could not be written: " + publication::error_text(errno));
}

void write_all(int file, std::string_view bytes, const std::filesystem::path& path) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail_to_write(path);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

bool read_all(int file, void* bytes, std::size_t count, std::uint64_t offset) {
  auto* at = static_cast<char*>(bytes);
  while (count > 0) {
    const ssize_t read = ::pread(file, at, count, static_cast<off_t>(offset));
    if (read < 0 && errno == EINTR) continue;
    if (read <= 0) return false;
    at += read;
    offset += static_cast<std::uint64_t>(read);
    count -= static_cast<std::size_t>(read);
  }
  return true;
}

}  // namespace

ViewWriter::ViewWriter(const std::filesystem::path& file)
    : path_(file), file_(::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) {
  if (file_.get() < 0) fail_to_write(path_);
  write_all(file_.get(), {kHead.data(), kHead.size()}, path_);
}

void ViewWriter::add(ViewRecord kind, std::string_view bytes) {
  const RecordHead head{kind, static_cast<std::uint32_t>(bytes.size())};
  buffer_.assign(reinterpret_cast<const char*>(&head), sizeof head);
  buffer_ += bytes;
  write_all(file_.get(), buffer_, path_);
}

void ViewWriter::add(std::span<const TickSample> samples) {
  if (samples.empty()) return;
  add(ViewRecord::kTicks, {reinterpret_cast<const char*>(samples.data()), samples.size_bytes()});
}

ViewReader::ViewReader(const std::filesystem::path& file)
    : file_(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
  struct stat status {};
  if (file_.get() < 0 || ::fstat(file_.get(), &status) != 0)
    throw std::runtime_error("--open: " + file.string() + ": " + publication::error_text(errno));
  const auto size = static_cast<std::uint64_t>(status.st_size);
  std::array<char, kHead.size()> start{};
  const bool is_whole =
      S_ISREG(status.st_mode) && read_all(file_.get(), start.data(), start.size(), 0);
  if (!is_whole || start != kHead)
    throw std::runtime_error("--open: " + file.string() +
                             ": expected a view that scene_viewer --save wrote, of version 2");
  RecordHead head{};
  std::uint64_t offset = kHead.size();
  for (; read_all(file_.get(), &head, sizeof head, offset); offset += sizeof head + head.bytes) {
    Place place{.offset = offset + sizeof head, .bytes = head.bytes};
    if (place.offset + place.bytes > size || !is_known(head.kind)) break;
    if (head.kind == ViewRecord::kScene) scenes_.push_back(place);
    if (head.kind == ViewRecord::kFrame) frames_.push_back(place);
    if (head.kind == ViewRecord::kTicks && head.bytes >= sizeof(TickSample) &&
        read_all(file_.get(), &place.first_tick, sizeof place.first_tick, place.offset))
      ticks_.push_back(place);
  }
  if (offset < size)
    spdlog::warn("--open: {}: damaged or cut off at byte {}: the {} bytes from there are not shown",
                 file.string(), offset, size - offset);
}

std::optional<std::string> ViewReader::read(const Place& place) const {
  std::string bytes(place.bytes, '\0');
  if (!read_all(file_.get(), bytes.data(), bytes.size(), place.offset)) return std::nullopt;
  return bytes;
}

std::optional<std::string> ViewReader::scene(std::size_t i) const {
  return read(scenes_[i]);
}

std::optional<std::string> ViewReader::frame(std::size_t i) const {
  return read(frames_[i]);
}

std::vector<TickSample> ViewReader::ticks(std::uint64_t from, std::size_t most) const {
  std::vector<TickSample> found;
  auto place = std::upper_bound(
      ticks_.begin(), ticks_.end(), from,
      [](std::uint64_t tick, const Place& later) { return tick < later.first_tick; });
  if (place != ticks_.begin()) --place;
  for (; place != ticks_.end() && found.size() < most; ++place) {
    const auto bytes = read(*place);
    if (!bytes) break;
    std::vector<TickSample> samples(bytes->size() / sizeof(TickSample));
    std::memcpy(samples.data(), bytes->data(), samples.size() * sizeof(TickSample));
    const auto wanted = ticks_from(samples, from, most - found.size());
    found.insert(found.end(), wanted.begin(), wanted.end());
  }
  return found;
}

}  // namespace stillgrid::scene_viewer
