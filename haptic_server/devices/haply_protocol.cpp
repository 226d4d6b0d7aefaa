#include "haptic_server/devices/haply_protocol.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "proto/device_plugin.h"

namespace stillgrid::devices {
namespace {

using nlohmann::json;

constexpr int kMaxNesting = 16;
constexpr std::size_t kMaxDevices = 8;  // of a kind
constexpr double kMaxPosition_m = 10.0;
constexpr double kMaxVelocity_m_s = 100.0;
constexpr double kMaxForce_N = 1000.0;
constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};

/// A value and where it stands, which is written out only where it is refused.
struct Place {
  const json& value;
  const Place* parent = nullptr;
  std::string_view key{};
  int index = -1;

  [[nodiscard]] std::string path() const {
    if (parent == nullptr) return "";
    if (index >= 0) return parent->path() + '[' + std::to_string(index) + ']';
    const std::string before = parent->path();
    return before.empty() ? std::string(key) : before + '.' + std::string(key);
  }
  [[noreturn]] void refuse(const std::string& expected) const {
    throw HaplyProtocolError("the service's message: " + path() + ": expected " + expected);
  }
  [[nodiscard]] bool has(const char* name) const {
    return value.is_object() && value.contains(name);
  }
  /// Pre: of an object.
  [[nodiscard]] Place at(const char* name) const {
    static const json kNothing;
    const auto found = value.find(name);
    return {found == value.end() ? kNothing : *found, this, name};
  }
  [[nodiscard]] Place object(const char* name) const {
    const Place place = at(name);
    if (!place.value.is_object()) place.refuse("an object");
    return place;
  }
  [[nodiscard]] double number(const char* name, double limit) const {
    const Place place = at(name);
    const double number = place.value.is_number() ? place.value.get<double>() : NAN;
    if (!(std::abs(number) <= limit))
      place.refuse("a number from -" + std::to_string(static_cast<int>(limit)) + " to " +
                   std::to_string(static_cast<int>(limit)));
    return number;
  }
  [[nodiscard]] bool boolean(const char* name) const {
    const Place place = at(name);
    if (!place.value.is_boolean()) place.refuse("true or false");
    return place.value.get<bool>();
  }
  [[nodiscard]] Eigen::Vector3d vector(const char* name, double limit) const {
    const Place place = object(name);
    return {place.number("x", limit), place.number("y", limit), place.number("z", limit)};
  }
  [[nodiscard]] Eigen::Quaterniond quaternion(const char* name) const {
    const Place place = object(name);
    return {place.number("w", 2.0), place.number("x", 2.0), place.number("y", 2.0),
            place.number("z", 2.0)};
  }
};

void check_nesting(std::string_view text) {
  int depth = 0;
  bool is_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (is_string) {
      if (c == '\\') ++i;
      is_string = c != '"';
    } else if (c == '"') {
      is_string = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kMaxNesting)
        throw HaplyProtocolError("the service's message: expected at most " +
                                 std::to_string(kMaxNesting) + " levels of nesting");
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
}

std::string id_of(const Place& device) {
  const Place place = device.at("device_id");
  if (!place.value.is_string() || !is_haply_id(place.value.get_ref<const std::string&>()))
    place.refuse("1 to 32 letters, digits, '-', '_' or '.'");
  return place.value.get<std::string>();
}

/// A text for the user's eyes, which nothing is decided by.
std::string shown(const Place& parent, const char* name) {
  const Place place = parent.at(name);
  if (!place.value.is_string()) return "";
  std::string text = place.value.get_ref<const std::string&>().substr(0, 48);
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return text;
}

/// What a placement does to the device's own frame; empty where it leaves it as it is.
std::string foreign_part(const Place& parent, const char* name) {
  constexpr double kNone = 1e-6, kNoTurn = 1e-3;
  if (!parent.has(name)) return "";
  // Whether its length is one or not.
  const auto turns = [](const Eigen::Quaterniond& q) {
    return !(q.vec().norm() <= kNoTurn * std::abs(q.w()) && q.w() != 0.0);
  };
  const Place placement = parent.object(name);
  const bool is_own =
      (!placement.has("position") || placement.vector("position", 1e3).norm() <= kNone) &&
      (!placement.has("rotation") || !turns(placement.quaternion("rotation"))) &&
      (!placement.has("scale") ||
       (placement.vector("scale", 1e3) - Eigen::Vector3d::Ones()).norm() <= kNone);
  return is_own ? "" : "a " + std::string(name);
}

void read_config(const Place& config, HaplyArm& arm) {
  arm.type = shown(config, "type");
  arm.firmware = shown(config, "extended_firmware_version");
  if (arm.firmware.empty() && config.has("device_info")) {
    const Place info = config.object("device_info");
    if (info.has("major_version") && info.has("minor_version"))
      arm.firmware = std::to_string(std::lround(info.number("major_version", 1e6))) + '.' +
                     std::to_string(std::lround(info.number("minor_version", 1e6)));
  }
  if (config.has("basis")) {  // came with 3.5, which documents 'vector'
    arm.spelling = HaplySpelling::kVector;
    const std::string permutation = shown(config.object("basis"), "permutation");
    if (permutation != "XYZ") arm.foreign_frame = "the basis " + permutation;
  }
  if (arm.foreign_frame.empty()) arm.foreign_frame = foreign_part(config, "mount");
}

void read_status(const Place& status, HaplyArm& arm) {
  const auto tell = [&arm](std::uint32_t bit, bool is_so) {
    arm.status_known |= bit;
    if (is_so) arm.status |= bit;
  };
  if (status.has("calibrated")) tell(STILLGRID_STATUS_CALIBRATED, status.boolean("calibrated"));
  bool has_motors = true;
  for (const char* const name : {"power_supply", "started", "ready"}) {
    if (!status.has(name)) continue;
    has_motors = status.boolean(name) && has_motors;
    tell(STILLGRID_STATUS_MOTORS_ON, false);
  }
  if (has_motors) arm.status |= arm.status_known & STILLGRID_STATUS_MOTORS_ON;
}

HaplyArm read_arm(const Place& device) {
  if (!device.value.is_object()) device.refuse("an object");
  HaplyArm arm;
  arm.id = id_of(device);
  if (device.has("config")) read_config(device.object("config"), arm);
  const Place state = device.object("state");
  arm.position_m = state.vector("cursor_position", kMaxPosition_m);
  arm.velocity_m_s = state.vector("cursor_velocity", kMaxVelocity_m_s);
  if (state.has("current_cursor_force"))
    arm.force_N = state.vector("current_cursor_force", kMaxForce_N);
  if (arm.foreign_frame.empty()) arm.foreign_frame = foreign_part(state, "transform");
  if (device.has("status")) read_status(device.object("status"), arm);
  return arm;
}

HaplyGrip read_grip(const Place& device) {
  if (!device.value.is_object()) device.refuse("an object");
  HaplyGrip grip;
  grip.id = id_of(device);
  if (!device.has("state")) return grip;
  const Place state = device.object("state");
  if (state.has("orientation")) {
    const Eigen::Quaterniond told = state.quaternion("orientation");
    // A grip that sleeps tells zeros: no orientation, rather than a fault.
    if (std::abs(told.norm() - 1.0) < 0.1) grip.orientation = told.normalized();
  }
  if (state.has("button")) {
    grip.button_count = 1;
    grip.buttons = state.boolean("button") ? 1 : 0;
  } else if (state.has("buttons")) {
    const Place buttons = state.object("buttons");
    grip.button_count = 3;
    for (const auto& [name, bit] : {std::pair{"a", 1U}, {"b", 2U}, {"c", 4U}})
      if (buttons.has(name) && buttons.boolean(name)) grip.buttons |= bit;
  }
  return grip;
}

template <class Device, class Read>
void read_list(const Place& message, const char* name, std::vector<Device>& devices,
               const Read& read) {
  if (!message.has(name)) return;
  const Place list = message.at(name);
  if (!list.value.is_array() || list.value.size() > kMaxDevices)
    list.refuse("a list of at most " + std::to_string(kMaxDevices) + " devices");
  int index = 0;
  for (const json& value : list.value) {
    const Place place{value, &list, {}, index++};
    Device device = read(place);
    for (const Device& other : devices)
      if (other.id == device.id) place.refuse("a device_id of its own, not again " + device.id);
    devices.push_back(std::move(device));
  }
}

void append_number(std::string& text, double number) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number,
                                 std::chars_format::fixed, 6);
  text.append(digits.data(), end.ptr);
}

template <class Devices>
auto find_id(const Devices& devices, std::string_view id) noexcept {
  const auto found = std::find_if(devices.begin(), devices.end(),
                                  [id](const auto& device) { return device.id == id; });
  return found == devices.end() ? nullptr : &*found;
}

}  // namespace

const HaplyArm* HaplyMessage::arm(std::string_view id) const noexcept {
  return find_id(arms, id);
}

const HaplyGrip* HaplyMessage::grip(std::string_view id) const noexcept {
  return find_id(grips, id);
}

bool is_haply_id(std::string_view text) noexcept {
  return !text.empty() && text.size() <= 32 && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '-' ||
           c == '_' || c == '.';
  });
}

HaplyMessage read_haply_message(std::string_view text) {
  if (text.size() > kMaxHaplyMessage)
    throw HaplyProtocolError("the service's message: expected at most 64 KiB");
  check_nesting(text);
  const json value = json::parse(text, nullptr, false);
  if (!value.is_object()) throw HaplyProtocolError("the service's message: expected a JSON object");
  const Place root{value};
  HaplyMessage message;
  read_list(root, "inverse3", message.arms, read_arm);
  for (const char* const kind : {"wireless_verse_grip", "custom_verse_grip", "verse_grip"})
    read_list(root, kind, message.grips, read_grip);
  return message;
}

void write_haply_force(std::string& text, std::string_view id, HaplySpelling spelling,
                       const Eigen::Vector3d& force_N) {
  text.assign(R"({"inverse3":[{"device_id":")").append(id);
  text.append(R"(","commands":{"set_cursor_force":{")");
  text.append(spelling == HaplySpelling::kVector ? "vector" : "values").append("\":");
  for (int axis = 0; axis < 3; ++axis) {
    text.append(axis == 0 ? "{\"" : ",\"").append(kAxes[static_cast<std::size_t>(axis)]);
    append_number(text.append("\":"), force_N[axis]);
  }
  text.append("}}}}]}");
}

}  // namespace stillgrid::devices
