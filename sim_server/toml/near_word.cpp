#include "sim_server/toml/near_word.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <string>
#include <vector>

namespace stillgrid::toml {
namespace {

constexpr std::size_t kLongestWord = 64;  // what is longer is no slip

/// What ends keys for their units, those of other sizes too.
constexpr std::array<std::string_view, 24> kUnits = {
    "m",   "mm",  "cm",  "um", "kg", "g",  "s",  "ms", "us", "hz",   "khz", "n",
    "per", "rad", "deg", "j",  "s2", "m2", "m3", "mn", "kn", "xyzw", "pa",  "kpa"};

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

std::string in_lower(std::string_view text) {
  std::string word(text);
  std::ranges::transform(word, word.begin(), lower);
  std::ranges::replace(word, '-', '_');
  return word;
}

/// A key without its units.
std::string stem_of(std::string_view text) {
  std::string stem = in_lower(text);
  for (auto last = stem.rfind('_'); last != std::string::npos && last > 0; last = stem.rfind('_')) {
    if (std::ranges::find(kUnits, std::string_view(stem).substr(last + 1)) == kUnits.end()) break;
    stem.resize(last);
  }
  return stem;
}

std::string singular(std::string word) {
  if (word.size() > 4 && word.ends_with("ies")) return word.substr(0, word.size() - 3) + "y";
  if (word.size() > 3 && word.ends_with('s') && !word.ends_with("ss")) word.pop_back();
  return word;
}

/// Letters added, lost, changed or swapped with the next one (optimal string alignment).
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> at(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        at[i][j] = i + j;
        continue;
      }
      const std::size_t changed = at[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      at[i][j] = std::min({at[i - 1][j] + 1, at[i][j - 1] + 1, changed});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        at[i][j] = std::min(at[i][j], at[i - 2][j - 2] + 1);
    }
  }
  return at[a.size()][b.size()];
}

bool ends_as_words(std::string_view longer, std::string_view shorter) {
  constexpr std::size_t kTelling = 3;
  return shorter.size() >= kTelling && longer.size() > shorter.size() &&
         longer.ends_with(shorter) && longer[longer.size() - shorter.size() - 1] == '_';
}

}  // namespace

bool is_near(std::string_view written, std::string_view word) {
  if (written == word || written.size() > kLongestWord || word.size() > kLongestWord) return false;
  const std::string a = stem_of(written), b = stem_of(word);
  if (singular(a) == singular(b) || ends_as_words(b, a)) return true;
  return distance(a, b) <= std::max(a.size(), b.size()) / 4;
}

std::optional<std::string_view> near_word(std::string_view written,
                                          std::span<const std::string_view> words) {
  std::optional<std::string_view> nearest;
  std::size_t least = 0;
  for (const std::string_view word : words) {
    if (!is_near(written, word)) continue;
    const std::size_t apart = distance(in_lower(written), in_lower(word));
    if (nearest && apart >= least) continue;
    nearest = word;
    least = apart;
  }
  return nearest;
}

}  // namespace stillgrid::toml
