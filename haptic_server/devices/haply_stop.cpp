#include "haptic_server/devices/haply_stop.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <Eigen/Core>

#include "haptic_server/devices/driver_host.hpp"
#include "haptic_server/devices/haply_protocol.hpp"

namespace stillgrid::devices {
namespace {

/// A whole text frame of a client (RFC 6455, 5.2). Its mask is zero, which leaves the text as it
/// is.
std::string frame_of(const std::string& text) {
  constexpr char kFinalText = '\x81';
  constexpr auto kMasked = 0x80U;
  std::string frame(1, kFinalText);
  if (text.size() < 126) {
    frame += static_cast<char>(kMasked | text.size());
  } else {  // 16 bits of length hold any message with an id of 32 letters
    frame += static_cast<char>(kMasked | 126U);
    frame += static_cast<char>(text.size() >> 8U);
    frame += static_cast<char>(text.size() & 0xffU);
  }
  return frame.append(4, '\0').append(text);
}

}  // namespace

HaplyStop::HaplyStop() : file_(open("/dev/null", O_RDONLY | O_CLOEXEC)) {
  if (file_ < 0) throw DriverError(STILLGRID_DEVICE_E_IO, "too many open files: expected one more");
}

HaplyStop::~HaplyStop() {
  close(file_);
}

void HaplyStop::arm(int socket, std::string_view arm) {
  is_armed_ = false;
  frames_.clear();
  std::string text;
  for (const HaplySpelling spelling : {HaplySpelling::kVector, HaplySpelling::kValues}) {
    write_haply_force(text, arm, spelling, Eigen::Vector3d::Zero());
    frames_ += frame_of(text);
  }
  if (dup3(socket, file_, O_CLOEXEC) < 0)
    throw DriverError(STILLGRID_DEVICE_E_IO, "too many open files: expected one more");
  is_stopped_ = false;
  is_armed_ = true;
}

void HaplyStop::send_zero() const noexcept {
  (void)!send(file_, frames_.data(), frames_.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
}

void HaplyStop::stop() noexcept {
  is_stopped_ = true;
  if (is_armed_) send_zero();
}

}  // namespace stillgrid::devices
