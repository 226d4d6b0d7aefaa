#include <unistd.h>

#include <cstring>

#include "tests/integration/vendors/fake_device.hpp"

// A fake of ours of Force Dimension's SDK: the functions that our driver uses, by their published
// names. One omega.7 is there, of serial number 4711; for tests alone, never installed.
namespace {

using stillgrid::integration::FakeDevice;

FakeDevice& device() {
  static FakeDevice fake;
  return fake;
}

thread_local int last_error = 0;
bool is_forceful = false;

int fail(int error) noexcept {
  last_error = error;
  return -1;
}

/// Whether the device answers no more.
bool is_lost() noexcept {
  return device().shows("lost");
}

bool is_right(char id) noexcept {
  return id == 5;
}

}  // namespace

#define FAKE extern "C" __attribute__((visibility("default")))

FAKE void dhdGetSDKVersion(int* major, int* minor, int* release, int* revision) {
  *major = device().has("version") ? 2 : 3;
  *minor = 17;
  *release = *revision = 0;
}
FAKE int dhdErrorGetLast() {
  return last_error;
}
FAKE const char* dhdErrorGetStr(int error) {
  switch (error) {
    case 2:
      return "communication error";
    case 5:
      return "no device found";
    case 20:
      return "device in use";
    default:
      return error == 0 ? "no error" : "undocumented error";
  }
}
FAKE int dhdGetDeviceCount() {
  return device().has("none") ? 0 : 1;
}
FAKE int dhdOpen() {
  return device().has("busy") ? fail(20) : 5;
}
FAKE int dhdOpenID(char index) {
  return index == 0 ? dhdOpen() : fail(5);
}
FAKE int dhdOpenSerial(int serial) {
  return serial == 4711 ? dhdOpen() : fail(5);
}
FAKE int dhdClose(char) {
  return 0;
}
FAKE int dhdGetSerialNumber(unsigned short* serial, char) {
  *serial = 4711;
  return 0;
}
FAKE const char* dhdGetSystemName(char) {
  return "omega.7";
}
#ifndef FAKE_WITHOUT_STATUS
FAKE int dhdGetStatus(int* status, char) {
  if (is_lost()) return fail(2);
  std::memset(status, 0, 16 * sizeof *status);
  const bool has_force = is_forceful && !device().shows("motors_off") && !device().shows("deadman");
  status[0] = 1;
  status[1] = device().shows("unplugged") ? 0 : 1;
  status[3] = device().shows("reset") ? 1 : 0;
  status[5] = has_force ? 1 : 0;
  status[9] = device().shows("fault") ? 1 : 0;
  status[14] = device().shows("deadman") ? 6 : 0;
  return 0;
}
#endif
FAKE bool dhdHasWrist(char) {
  return true;
}
FAKE bool dhdHasActiveWrist(char) {
  return false;
}
FAKE bool dhdHasGripper(char) {
  return true;
}
FAKE bool dhdHasActiveGripper(char) {
  return true;
}
FAKE int dhdStop(char) {
  is_forceful = false;
  device().motors_off();
  return 0;
}
FAKE int dhdEnableForce(unsigned char is_on, char) {
  is_forceful = is_on != 0;
  if (is_forceful) device().motors_on();
  return 0;
}
FAKE int dhdSetBrakes(int, char) {
  return 0;
}
FAKE int dhdSetGravityCompensation(int, char) {
  return 0;
}
FAKE int dhdGetPosition(double* x, double* y, double* z, char id) {
  if (is_lost() || !is_right(id)) return fail(2);
  if (device().shows("stall")) ::usleep(300'000);
  device().advance();
  *x = device().position_m[0];
  *y = device().position_m[1];
  *z = device().read(device().position_m[2]);
  return 0;
}
FAKE int dhdGetOrientationFrame(double (*rows)[3], char) {
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) rows[row][column] = row == column ? 1.0 : 0.0;
  if (device().shows("sheared")) rows[0][1] = 0.5;
  return 0;
}
FAKE int dhdGetLinearVelocity(double* x, double* y, double* z, char) {
  *x = device().velocity_m_s[0];
  *y = device().velocity_m_s[1];
  *z = device().velocity_m_s[2];
  return 0;
}
FAKE int dhdGetGripperGap(double* gap, char) {
  *gap = 0.01;
  return 0;
}
FAKE unsigned dhdGetButtonMask(char) {
  return 0;
}
FAKE int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double, double,
                                             double, double, char) {
  device().tell({fx, fy, fz});
  return is_lost() || device().shows("no_force") ? fail(2) : 0;
}
FAKE int dhdEnableExpertMode() {
  return 0;
}
FAKE int dhdDisableExpertMode() {
  return 0;
}
FAKE int dhdSetWatchdog(unsigned char, char) {
  return device().has("no_watchdog") ? fail(6) : 0;
}
