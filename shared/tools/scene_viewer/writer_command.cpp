#include "shared/tools/scene_viewer/writer_command.hpp"

#include <algorithm>
#include <fstream>

#include "shared/publication/hands.hpp"

namespace stillgrid::scene_viewer {
namespace {

constexpr std::size_t kMaxBytes = 4096;

/// What stands between zeros.
std::vector<std::string> words_of(std::uint32_t pid) {
  std::ifstream in("/proc/" + std::to_string(pid) + "/cmdline");
  std::vector<std::string> words;
  std::size_t bytes = 0;
  for (std::string word; std::getline(in, word, '\0'); words.push_back(word)) {
    bytes += word.size() + 1;
    if (bytes > kMaxBytes) return {};
  }
  return words;
}

bool is_plain(char c) {
  constexpr std::string_view kOthers = "_-./:=,+@%";
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         kOthers.find(c) != std::string_view::npos;
}

bool is_control(char c) {
  return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
}

std::string quoted(const std::string& word) {
  if (!word.empty() && std::all_of(word.begin(), word.end(), is_plain)) return word;
  std::string text = "'";
  for (const char c : word) c == '\'' ? text += "'\\''" : text += c;
  text += '\'';
  return text;
}

}  // namespace

std::string shell_line(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) {
    if (std::any_of(word.begin(), word.end(), is_control)) return {};
    if (!line.empty()) line += ' ';
    line += quoted(word);
  }
  return line;
}

WriterCommand::WriterCommand(std::string_view hand_session)
    : session_(publication::session_of(hand_session)) {}

void WriterCommand::look(std::uint64_t epoch, std::uint32_t writer_pid) {
  if (epoch == epoch_) return;
  epoch_ = epoch;
  const std::vector<std::string> words = words_of(writer_pid);
  std::string joined = "--session=";
  joined += session_;
  const bool names_it = std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return word == session_ || word == joined;
  });
  line_ = names_it ? shell_line(words) : "";
}

}  // namespace stillgrid::scene_viewer
