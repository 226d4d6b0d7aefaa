#include "haptic_server/devices/openhaptics_library.hpp"

namespace stillgrid::devices {

OpenHapticsLibrary::OpenHapticsLibrary(const std::string& path)
    : library(path, {"libHD.so", "libHD.so.3.4", "libHD.so.3.0"}) {
  library.bind(init_device, "hdInitDevice");
  library.bind(disable_device, "hdDisableDevice");
  library.bind(make_current_device, "hdMakeCurrentDevice");
  library.bind(begin_frame, "hdBeginFrame");
  library.bind(end_frame, "hdEndFrame");
  library.bind(get_error, "hdGetError");
  library.bind(get_error_string, "hdGetErrorString");
  library.bind(enable, "hdEnable");
  library.bind(disable, "hdDisable");
  library.bind(is_enabled, "hdIsEnabled");
  library.bind(get_integerv, "hdGetIntegerv");
  library.bind(get_doublev, "hdGetDoublev");
  library.bind(get_string, "hdGetString");
  library.bind(set_doublev, "hdSetDoublev");
  library.bind(check_calibration, "hdCheckCalibration");
  library.bind(update_calibration, "hdUpdateCalibration");
  library.bind(start_scheduler, "hdStartScheduler");
  library.bind(stop_scheduler, "hdStopScheduler");
  library.bind(set_scheduler_rate, "hdSetSchedulerRate");
  library.bind(schedule_asynchronous, "hdScheduleAsynchronous");
  library.bind(unschedule, "hdUnschedule");
}

HdError OpenHapticsLibrary::take_error() const noexcept {
  const HdError newest = get_error();
  constexpr int kMaxErrors = 64;  // a stack that never ends must not hold a thread
  if (newest.code == kHdSuccess) return newest;
  for (int n = 0; n < kMaxErrors && get_error().code != kHdSuccess; ++n) {
  }
  return newest;
}

std::string OpenHapticsLibrary::text_of(unsigned parameter) const {
  const char* const text = get_string(parameter);
  return text == nullptr ? "" : text;
}

}  // namespace stillgrid::devices
