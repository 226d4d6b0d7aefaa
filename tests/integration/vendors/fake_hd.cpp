#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <thread>

#include "tests/integration/vendors/fake_device.hpp"

// A fake of ours of OpenHaptics' HD API: the functions that our driver uses, by their published
// names, and a scheduler with a thread of its own at 1 kHz. One Touch is there, of serial number
// T-0815; for tests alone, never installed.
namespace {

using stillgrid::integration::FakeDevice;
using stillgrid::integration::Vector;
using Callback = unsigned (*)(void*);

FakeDevice& device() {
  static FakeDevice fake;
  return fake;
}

constexpr unsigned kDevice = 3;
std::atomic<unsigned> error = 0;  // a stack of one
std::atomic<bool> is_running = false, is_forceful = false, is_in_frame = false;
std::atomic<Callback> callback = nullptr;
std::atomic<void*> callback_data = nullptr;
std::thread scheduler;
Vector frame_force_N{};

void show_faults() noexcept {
  if (device().shows("lost")) error = 0x0302;
  if (device().shows("warm")) error = 0x0200;
  if (device().shows("max_force")) error = 0x0201;
  if (device().shows("max_velocity")) error = 0x0203;
  if (device().shows("device_fault")) error = 0x0300;
}

void schedule() {
  auto next = std::chrono::steady_clock::now();
  while (is_running) {
    next += std::chrono::milliseconds(1);
    device().advance();
    const Callback function = callback;
    const bool is_silent = device().shows("silent");
    if (function != nullptr && !is_silent && function(callback_data) == 0) callback = nullptr;
    if (device().shows("stall")) std::this_thread::sleep_for(std::chrono::milliseconds(300));
    std::this_thread::sleep_until(next);
  }
}

}  // namespace

struct HdErrorInfo {
  unsigned code;
  int internal;
  unsigned device;
};

#define FAKE extern "C" __attribute__((visibility("default")))

FAKE unsigned hdInitDevice(const char* name) {
  if (device().has("busy")) error = 0x0301;
  if (device().has("none") || (name != nullptr && std::strcmp(name, "Absent") == 0)) error = 0x0302;
  if (device().has("licence")) error = 0x0600;
  return error == 0 ? kDevice : 0xFFFFFFFF;
}
FAKE void hdDisableDevice(unsigned) {}
FAKE void hdMakeCurrentDevice(unsigned) {}
FAKE void hdBeginFrame(unsigned) {
  is_in_frame = true;
  frame_force_N = {};
}
FAKE void hdEndFrame(unsigned) {
  if (!is_in_frame.exchange(false)) error = 0x0401;
  device().tell(frame_force_N);
  show_faults();
}
FAKE HdErrorInfo hdGetError() {
  return {error.exchange(0), 0, kDevice};
}
FAKE const char* hdGetErrorString(unsigned code) {
  switch (code) {
    case 0x0300:
      return "HD_DEVICE_FAULT";
    case 0x0301:
      return "HD_DEVICE_ALREADY_INITIATED";
    case 0x0302:
      return "HD_COMM_ERROR";
    case 0x0600:
      return "HD_INVALID_LICENSE";
    default:
      return "HD_ERROR";
  }
}
FAKE void hdEnable(unsigned) {
  is_forceful = true;
  device().motors_on();
}
FAKE void hdDisable(unsigned) {
  is_forceful = false;
  device().motors_off();
}
FAKE unsigned char hdIsEnabled(unsigned) {
  return is_forceful && !device().shows("motors_off") ? 1 : 0;
}
FAKE void hdGetIntegerv(unsigned parameter, int* number) {
  *number = parameter == 0x2555 ? 4 : 0;  // style of calibration: inkwell
}
#ifndef FAKE_WITHOUT_GET_DOUBLEV
FAKE void hdGetDoublev(unsigned parameter, double* numbers) {
  const Vector& at_m = device().position_m;
  const Vector& velocity = device().velocity_m_s;
  static constexpr double kCorners[6] = {-210.0, -110.0, -85.0, 210.0, 205.0, 130.0};
  switch (parameter) {
    case 0x2050:
      for (std::size_t axis = 0; axis < 3; ++axis) numbers[axis] = 1e3 * at_m[axis];
      break;
    case 0x2051:
      for (std::size_t axis = 0; axis < 3; ++axis) numbers[axis] = 1e3 * velocity[axis];
      break;
    case 0x2052:
      for (int n = 0; n < 16; ++n) numbers[n] = n % 5 == 0 ? 1.0 : 0.0;
      for (std::size_t axis = 0; axis < 3; ++axis) numbers[12 + axis] = 1e3 * at_m[axis];
      numbers[14] = device().read(numbers[14]);
      if (device().shows("sheared")) numbers[4] = 0.5;
      break;
    case 0x2550:
      std::memcpy(numbers, kCorners, sizeof kCorners);
      break;
    case 0x2602:
      numbers[0] = 1.02;
      break;
    case 0x2603:
      numbers[0] = 3.3;
      break;
    case 0x2604:
      numbers[0] = 0.88;
      break;
    case 0x2605:
      for (int motor = 0; motor < 6; ++motor) numbers[motor] = 0.2;
      if (device().shows("hot")) numbers[1] = 1.1;
      break;
    default:
      error = 0x0100;
  }
}
#endif
FAKE const char* hdGetString(unsigned parameter) {
  switch (parameter) {
    case 0x2500:
      return device().has("version") ? "2.0.1" : "3.4.0";
    case 0x2501:
      return "Touch";
    case 0x2504:
      return "T-0815";
    default:
      return "";
  }
}
FAKE void hdSetDoublev(unsigned parameter, const double* numbers) {
  if (parameter == 0x2700 && is_in_frame) frame_force_N = {numbers[0], numbers[1], numbers[2]};
}
FAKE unsigned hdCheckCalibration() {
  return device().shows("uncalibrated") ? 0x5002 : 0x5000;
}
FAKE void hdUpdateCalibration(unsigned) {}
FAKE void hdSetSchedulerRate(unsigned long) {}
FAKE unsigned long hdScheduleAsynchronous(Callback function, void* data, unsigned short) {
  callback_data = data;
  callback = function;
  return 1;
}
FAKE void hdUnschedule(unsigned long) {
  callback = nullptr;
}
FAKE void hdStartScheduler() {
  if (device().has("no_callbacks") || is_running.exchange(true)) return;
  scheduler = std::thread(schedule);
}
FAKE void hdStopScheduler() {
  if (is_running.exchange(false)) scheduler.join();
}
