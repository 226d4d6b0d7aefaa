#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace stillgrid::devices {

/// A message of the service is no longer than this; an inventory of two devices has some 4 KiB.
constexpr std::size_t kMaxHaplyMessage = 65536;

/// What is wrong with a message of the service's, in one line: where, and what was expected.
class HaplyProtocolError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// How set_cursor_force names its vector. The service ignores the name that it does not know.
enum class HaplySpelling {
  kValues,  // clients of 3.1 to 3.4 [IsaacLab se3_haply.py, SofaHaplyRobotics]
  kVector,  // documented for 3.5 [docs.haply.co, service/realtime/control-commands]
};

/// One Inverse3 in a message, in its own frame: x right, y forward, z up.
struct HaplyArm {
  std::string id;             // 1 to 32 letters, digits, '-', '_' or '.'
  std::string type;           // as "inverse3", "minverse"; of an inventory, else empty
  std::string firmware;       // likewise
  HaplySpelling spelling{};   // that of the version which wrote an inventory
  std::string foreign_frame;  // what sets its frame apart from the device's own; empty: nothing
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector3d> force_N;  // that the service says it applies
  std::uint32_t status = 0;                // STILLGRID_STATUS_..., as of stillgrid_device_state
  std::uint32_t status_known = 0;
};

/// One VerseGrip in a message.
struct HaplyGrip {
  std::string id;  // as HaplyArm's
  std::optional<Eigen::Quaterniond> orientation;
  std::uint32_t buttons = 0;  // a, b, c, or the one button
  std::uint32_t button_count = 0;
};

/// What the service tells in one message, as it stands there.
struct HaplyMessage {
  std::vector<HaplyArm> arms;
  std::vector<HaplyGrip> grips;

  [[nodiscard]] const HaplyArm* arm(std::string_view id) const noexcept;
  [[nodiscard]] const HaplyGrip* grip(std::string_view id) const noexcept;
};

/// Reads a message of the service: its inventory, or one state update of service 3.1 to 3.5.
///
/// Fields that are not used are passed over, those that are used have their type, are finite and in
/// range: 10 m, 100 m/s and 1000 N on each axis.
/// Throws HaplyProtocolError.
[[nodiscard]] HaplyMessage read_haply_message(std::string_view text);

/// Whether a text may be a device's id.
[[nodiscard]] bool is_haply_id(std::string_view text) noexcept;

/// Writes the message that commands this force, into text.
/// Pre: is_haply_id(id), force_N finite.
void write_haply_force(std::string& text, std::string_view id, HaplySpelling spelling,
                       const Eigen::Vector3d& force_N);

}  // namespace stillgrid::devices
