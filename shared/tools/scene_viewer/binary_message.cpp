#include "shared/tools/scene_viewer/binary_message.hpp"

#include <nlohmann/json.hpp>

#include "shared/tools/segment_inspect/inspection_json.hpp"

namespace stillgrid::scene_viewer {

std::string binary_message(nlohmann::ordered_json head,
                           std::initializer_list<MessageArray> arrays) {
  auto& list = head["arrays"] = nlohmann::ordered_json::array();
  std::size_t array_bytes = 0;
  for (const MessageArray& array : arrays) {
    list.push_back({{"name", array.name}, {"type", array.type}, {"count", array.count}});
    array_bytes += array.bytes.size();
  }
  std::string text = segment_inspect::text_of(head);
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const auto length = static_cast<std::uint32_t>(text.size());
  std::string message;
  message.reserve(4 + text.size() + array_bytes);
  for (unsigned shift = 0; shift < 32; shift += 8)
    message += static_cast<char>((length >> shift) & 0xFFU);
  message += text;
  for (const MessageArray& array : arrays)
    message.append(reinterpret_cast<const char*>(array.bytes.data()), array.bytes.size());
  return message;
}

std::string binary_message(std::initializer_list<MessageArray> arrays) {
  return binary_message(nlohmann::ordered_json::object(), arrays);
}

}  // namespace stillgrid::scene_viewer
