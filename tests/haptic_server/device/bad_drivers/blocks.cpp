#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <mutex>
#include <thread>

#include "proto/device_plugin.h"

// A driver whose read() blocks at every tenth tick, in the way that the option call= names: malloc,
// mutex, file or sleep. It still reports the pose, so that nothing else ends the run.
namespace {

struct Driver {
  std::array<char, 16> call{};
  std::uint64_t ticks = 0;
  int file = -1;
  std::mutex mutex;
  std::unique_ptr<std::array<char, 256>> memory;

  [[nodiscard]] bool blocks_by(const char* name) const {
    return std::strcmp(call.data(), name) == 0;
  }
};

Driver driver;

std::int32_t enumerate() {
  return 1;
}
std::int32_t open_device(std::uint32_t /*index*/, stillgrid_device** out) {
  *out = reinterpret_cast<stillgrid_device*>(&driver);
  return STILLGRID_DEVICE_OK;
}
std::int32_t configure(stillgrid_device* /*device*/, const char* /*key*/, const char* value) {
  std::strncpy(driver.call.data(), value, driver.call.size() - 1);
  return STILLGRID_DEVICE_OK;
}
std::int32_t describe(stillgrid_device* /*device*/, stillgrid_device_descriptor* /*out*/) {
  return STILLGRID_DEVICE_OK;
}
std::int32_t activate(stillgrid_device* /*device*/) {
  driver.file = open("/dev/null", O_WRONLY | O_CLOEXEC);
  return driver.file >= 0 ? STILLGRID_DEVICE_OK : STILLGRID_DEVICE_E_IO;
}

void block() {
  if (driver.blocks_by("malloc")) driver.memory = std::make_unique<std::array<char, 256>>();
  if (driver.blocks_by("mutex")) const std::lock_guard one_at_a_time(driver.mutex);
  if (driver.blocks_by("sleep")) std::this_thread::sleep_for(std::chrono::microseconds(10));
  if (driver.blocks_by("file") && write(driver.file, "tick\n", 5) != 5) driver.ticks = 0;
}

std::int32_t read_pose(stillgrid_device* /*device*/, std::uint64_t now_ns,
                       stillgrid_device_state* out) {
  if (++driver.ticks % 10 == 0) block();
  out->valid = STILLGRID_STATE_POSITION;
  out->time_ns = now_ns;
  out->sequence = driver.ticks;
  out->position_m[2] = 0.1;
  return STILLGRID_DEVICE_OK;
}
std::int32_t write_force(stillgrid_device* /*device*/, std::uint64_t /*now_ns*/,
                         const double* /*force_N*/, const double* /*torque_N_m*/) {
  return STILLGRID_DEVICE_OK;
}
std::int32_t deactivate(stillgrid_device* /*device*/) {
  return STILLGRID_DEVICE_OK;
}
void close_device(stillgrid_device* /*device*/) {
  close(driver.file);
}
void emergency_stop(stillgrid_device* /*device*/) {}
const char* strerror(stillgrid_device* /*device*/, std::int32_t /*code*/) {
  return "no error";
}

}  // namespace

extern "C" std::int32_t stillgrid_device_negotiate(const stillgrid_host_info* /*host*/,
                                                   stillgrid_device_api* out) {
  *out = {sizeof *out,  STILLGRID_DEVICE_ABI,
          enumerate,    open_device,
          configure,    describe,
          activate,     read_pose,
          write_force,  deactivate,
          close_device, emergency_stop,
          strerror,     nullptr,
          nullptr,      nullptr,
          nullptr,      nullptr};
  return STILLGRID_DEVICE_OK;
}
