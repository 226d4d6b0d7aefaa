#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "shared/realtime/stop_signal.hpp"
#include "sim_server/mesh/mesh_file.hpp"

namespace stillgrid::mesh {

/// The lines and words of a mesh file, with the place for messages. Blank lines, and what comes
/// after a # in any line, are passed over. Views of the text that it is made of.
class MeshText {
 public:
  MeshText(std::string_view text, std::string_view name) : rest_(text), name_(name) {}

  /// Goes on to the next line that holds a word; false at the end.
  bool next_line() {
    realtime::throw_if_stopped();
    while (!rest_.empty()) {
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      words_ = rest_.substr(0, end);
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      ++line_;
      words_ = words_.substr(0, words_.find('#'));
      skip_blanks();
      if (!words_.empty()) return true;
    }
    return false;
  }

  /// The next word of this line, empty at its end.
  std::string_view word() {
    const std::size_t end = std::min(words_.find_first_of(kBlanks), words_.size());
    const std::string_view word = words_.substr(0, end);
    words_.remove_prefix(end);
    skip_blanks();
    return word;
  }

  /// The next word of this line as a number; throws MeshError where it is none. A whole number has
  /// no more digits than fit.
  template <typename Number = double>
  Number number(const char* what) {
    const std::string_view text = word();
    const auto value = number_in<Number>(text);
    if (!value) refuse(std::string(what) + ": value '" + shown(text) + "': expected a number");
    return *value;
  }

  /// The same of this line or, at its end, of the next.
  template <typename Number = double>
  Number next_number(const char* what) {
    if (words_.empty() && !next_line())
      refuse(std::string(what) + ": the file ends: expected more");
    return number<Number>(what);
  }

  template <typename Number>
  [[nodiscard]] static std::optional<Number> number_in(std::string_view text) {
    if (text.starts_with('+')) text.remove_prefix(1);
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
  }

  /// What is left after this line.
  [[nodiscard]] std::string_view rest() const { return rest_; }
  [[nodiscard]] bool line_is_done() const { return words_.empty(); }

  [[noreturn]] void refuse(const std::string& what) const {
    throw MeshError(std::string(name_) + ":" + std::to_string(line_) + ": " + what);
  }

  /// A word for a message: short, and without what a terminal would obey.
  [[nodiscard]] static std::string shown(std::string_view text) {
    constexpr std::size_t kMax = 40;
    std::string result(text.substr(0, kMax));
    for (char& c : result)
      if (c < ' ' || c > '~') c = '?';
    return result;
  }

 private:
  static constexpr std::string_view kBlanks = " \t\r\v\f";
  void skip_blanks() {
    words_.remove_prefix(std::min(words_.find_first_not_of(kBlanks), words_.size()));
  }

  std::string_view rest_, words_;
  std::string_view name_;
  std::int64_t line_ = 0;
};

}  // namespace stillgrid::mesh
