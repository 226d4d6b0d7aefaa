#include "haptic_server/device/release_device.hpp"

#include <chrono>
#include <future>
#include <memory>
#include <thread>
#include <utility>

#include "haptic_server/device/negotiation.hpp"

namespace stillgrid::device {
namespace {

constexpr auto kLongestStop = std::chrono::milliseconds(100);

/// A thread that does not come back keeps its device: that one is never closed.
void stop_beside(const std::shared_ptr<Device>& device) {
  std::promise<void> stopped;
  const std::future<void> done = stopped.get_future();
  std::thread([device, stopped = std::move(stopped)]() mutable {
    device->emergency_stop();
    stopped.set_value();
  }).detach();
  static_cast<void>(done.wait_for(kLongestStop));
}

}  // namespace

void release_device(const DeviceSpec& spec, const DeviceLoop& loop, ReleaseWay way) {
  const auto device = std::make_shared<Device>(spec, loop);
  if (way == ReleaseWay::kStopAlone) return device->emergency_stop();
  if (way == ReleaseWay::kEveryCall) stop_beside(device);
  device->activate();
  if (const std::int32_t code = device->deactivate(); code != STILLGRID_DEVICE_OK)
    fail_device(DeviceFailure::kDeviceFault, spec.plugin,
                "deactivate: " + device->error_line(code));
}

}  // namespace stillgrid::device
