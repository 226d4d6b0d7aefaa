#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <string>
#include <string_view>

namespace stillgrid::recording {

/// Appends JSON to a text, a thousand times a second: what nlohmann's library would build as a tree
/// first. Numbers in the shortest form that reads back the same.
class JsonText {
 public:
  explicit JsonText(std::string& text) : text_(text) {}

  /// '{' or '[', and their ends.
  JsonText& open(char bracket) {
    separate();
    text_ += bracket;
    return *this;
  }
  JsonText& close(char bracket) {
    text_ += bracket;
    return *this;
  }
  /// Pre: neither name nor text holds what JSON escapes.
  JsonText& key(std::string_view name) {
    value(name);
    text_ += ':';
    return *this;
  }
  JsonText& value(std::string_view text) {
    separate();
    text_ += '"';
    text_ += text;
    text_ += '"';
    return *this;
  }
  JsonText& value(const char* text) { return value(std::string_view(text)); }
  JsonText& value(bool is_true) {
    separate();
    text_ += is_true ? "true" : "false";
    return *this;
  }
  template <class Number>
  requires(std::integral<Number> || std::floating_point<Number>) &&
      (!std::same_as<Number, bool>)JsonText& value(Number number) {
    separate();
    std::array<char, 32> digits;
    const char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
    text_.append(digits.data(), static_cast<std::size_t>(end - digits.data()));
    return *this;
  }

  /// A member; left out where it is no number, which JSON cannot say.
  template <class Value>
  JsonText& member(std::string_view name, Value given) {
    if constexpr (std::floating_point<Value>)
      if (!std::isfinite(given)) return *this;
    return key(name).value(given);
  }
  /// Of x, y, z.
  template <class Vector>
  JsonText& vector(std::string_view name, const Vector& v) {
    return key(name).open('{').member("x", v[0]).member("y", v[1]).member("z", v[2]).close('}');
  }

 private:
  void separate() {
    const char last = text_.empty() ? '{' : text_.back();
    if (last != '{' && last != '[' && last != ':') text_ += ',';
  }

  std::string& text_;
};

}  // namespace stillgrid::recording
