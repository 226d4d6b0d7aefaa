#include "sim_server/toml/toml_depth.hpp"

#include <algorithm>

namespace stillgrid::toml {
namespace {

constexpr int kMaxKeyParts = 16, kMaxBrackets = 16;

/// Walks through a text from one token that matters to the next.
class Walker {
 public:
  explicit Walker(std::string_view text) : text_(text) {}

  std::optional<DeepPlace> walk() {
    while (at_ < text_.size()) {
      const std::size_t begin = at_;
      const char c = text_[at_];
      if (c == '"' || c == '\'') {
        skip_string(c);
        continue;
      }
      if (c == '#') {
        at_ = std::min(text_.find('\n', at_), text_.size());
        continue;
      }
      ++at_;
      if (c == '.') {
        if (++parts_ > kMaxKeyParts) return place(begin, "key", kMaxKeyParts, "parts");
        continue;
      }
      if (!is_within_key(c)) parts_ = 1;
      if (c == '[' || c == '{') ++depth_;
      if ((c == ']' || c == '}') && depth_ > 0) --depth_;
      if (depth_ > kMaxBrackets) return place(begin, "value", kMaxBrackets, "brackets");
    }
    return std::nullopt;
  }

 private:
  /// Parts of one key have nothing else between them.
  static bool is_within_key(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '+' || c == ' ' || c == '\t';
  }

  /// Leaves at_ behind a string; a string of one line ends with its line at the latest.
  void skip_string(char quote) {
    const bool is_long = text_.substr(at_, 3) == std::string(3, quote);
    at_ += is_long ? 3 : 1;
    for (; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      if (quote == '"' && c == '\\')
        ++at_;
      else if (is_long && text_.substr(at_, 3) == std::string(3, quote)) {
        advance(3);  // and one or two quotes that the string ends with
        for (int k = 0; k < 2 && at_ < text_.size() && text_[at_] == quote; ++k) advance(1);
        return;
      } else if (!is_long && (c == quote || c == '\n'))
        return advance(1);
    }
  }

  void advance(std::size_t count) { at_ += count; }

  [[nodiscard]] DeepPlace place(std::size_t at, const char* thing, int most,
                                const char* parts) const {
    DeepPlace found;
    for (const char c : text_.substr(0, at)) {
      ++found.column;
      if (c != '\n') continue;
      ++found.line;
      found.column = 1;
    }
    found.expected =
        std::string("a ") + thing + " of at most " + std::to_string(most) + " " + parts;
    return found;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int parts_ = 1, depth_ = 0;
};

}  // namespace

std::optional<DeepPlace> find_deep_place(std::string_view text) {
  return Walker(text).walk();
}

}  // namespace stillgrid::toml
