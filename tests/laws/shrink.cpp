#include "tests/laws/shrink.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>

#include "tests/laws/tried.hpp"

namespace stillgrid::laws {
namespace {

/// A number of a line, from `from`: where it begins and ends; begin == end: none.
struct Span {
  std::size_t begin = 0, end = 0;
};

Span next_number(const std::string& line, std::size_t from) {
  bool in_text = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') in_text = !in_text;
    if (i < from || in_text || std::isdigit(static_cast<unsigned char>(line[i])) == 0) continue;
    if (i > 0 && (std::isalpha(static_cast<unsigned char>(line[i - 1])) != 0 ||
                  line[i - 1] == '_' || line[i - 1] == '.'))
      continue;
    std::size_t end = i;
    while (end < line.size() &&
           (std::isdigit(static_cast<unsigned char>(line[end])) != 0 || line[end] == '.' ||
            line[end] == 'e' || (line[end] == '-' && line[end - 1] == 'e')))
      ++end;
    return {i, end};
  }
  return {};
}

std::string rounded(const std::string& number, int digits) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", digits, std::strtod(number.c_str(), nullptr));
  std::string round = text;
  const bool is_whole = number.find_first_of(".e") == std::string::npos;
  if (is_whole) return number;  // counts are shrunk by their own law
  if (round.find_first_of(".e") == std::string::npos) round += ".0";
  return round;
}

double to_digits(double value, int digits) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return std::strtod(text, nullptr);
}

class Shrinker {
 public:
  Shrinker(const LawCase& law_case, int tries) : best_(law_case), tries_(tries) {
    const Finding finding = try_case(best_).finding;
    breaks_ = !finding.holds();
    least_excess_ = 0.3 * (finding.measured - finding.allowed);
  }

  LawCase run() {
    if (!breaks_) return best_;
    bool smaller = true;
    while (smaller && tries_ > 0) {
      smaller = drop_options();
      smaller = drop_sections() || smaller;
      smaller = drop_lines() || smaller;
      smaller = drop_tool_spheres() || smaller;
      smaller = shorten() || smaller;
      smaller = round_numbers() || smaller;
    }
    return best_;
  }

 private:
  /// Takes the changed case if it still breaks the law.
  bool take(const std::function<void(LawCase&)>& change) {
    if (tries_ <= 0) return false;
    LawCase changed = best_;
    change(changed);
    if (print_case(changed) == print_case(best_)) return false;
    --tries_;
    try {
      (void)scene_of(changed);
      // What is thrown by a law is a violation; a scene that is refused is none.
      const Tried tried = try_case(changed);
      const Finding& finding = tried.finding;
      if (tried.outcome == Outcome::kNoData || finding.holds()) return false;
      if (finding.measured - finding.allowed < least_excess_) return false;
    } catch (const std::exception&) {
      return false;
    }
    best_ = std::move(changed);
    return true;
  }

  bool drop_options() {
    bool any = take([](LawCase& c) { c.jitter = 0.0; });
    any = take([](LawCase& c) { c.latency_share = 0.0; }) || any;
    if (best_.latency_share != 0.0 && best_.latency_share != 1.0)
      any = take([](LawCase& c) { c.latency_share = 1.0; }) || any;
    any = take([](LawCase& c) { c.transition = "local"; }) || any;
    any = take([](LawCase& c) { c.model = "grid"; }) || any;
    any = take([](LawCase& c) { c.other_hand.reset(); }) || any;
    return take([](LawCase& c) { c.seed = 1; }) || any;
  }

  bool drop_sections() {
    bool any = false;
    for (std::size_t i = best_.scene.sections.size(); i-- > 1;)
      any = take([i](LawCase& c) {
              c.scene.sections.erase(c.scene.sections.begin() + static_cast<std::ptrdiff_t>(i));
            }) ||
            any;
    return any;
  }

  bool drop_lines() {
    bool any = false;
    for (std::size_t s = best_.scene.sections.size(); s-- > 1;)
      for (std::size_t l = best_.scene.sections[s].lines.size(); l-- > 0;)
        any = take([s, l](LawCase& c) {
                auto& lines = c.scene.sections[s].lines;
                lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(l));
              }) ||
              any;
    return any;
  }

  bool drop_tool_spheres() {
    bool any = false;
    for (std::size_t s = 0; s < best_.scene.sections.size(); ++s) {
      if (best_.scene.sections[s].head != "[tool]") continue;
      for (std::size_t l = 0; l < best_.scene.sections[s].lines.size(); ++l)
        while (take([s, l](LawCase& c) {
          std::string& line = c.scene.sections[s].lines[l];
          const auto last = line.rfind(", { ");
          if (last != std::string::npos) line = line.substr(0, last) + "]";
        }))
          any = true;
    }
    return any;
  }

  bool shorten() {
    bool any = false;
    constexpr double kShortest_s = 0.02;
    for (const double share : {0.5, 0.8})
      while (best_.duration_s > kShortest_s && take([share](LawCase& c) { c.duration_s *= share; }))
        any = true;
    return take([](LawCase& c) { c.duration_s = to_digits(c.duration_s, 2); }) || any;
  }

  bool round_numbers() {
    bool any = round_hand();
    for (const int digits : {1, 2})
      for (std::size_t s = 1; s < best_.scene.sections.size(); ++s)
        for (std::size_t l = 0; l < best_.scene.sections[s].lines.size(); ++l)
          any = round_line(s, l, digits) || any;
    return any;
  }

  bool round_line(std::size_t s, std::size_t l, int digits) {
    bool any = false;
    std::size_t from = 0;
    while (true) {
      const std::string line = best_.scene.sections[s].lines[l];
      const Span span = next_number(line, std::max(from, line.find('=')));
      if (span.end == span.begin) return any;
      from = span.end;
      const std::string number = line.substr(span.begin, span.end - span.begin);
      const std::string round = rounded(number, digits);
      if (round.size() >= number.size()) continue;
      if (!take([&](LawCase& c) {
            c.scene.sections[s].lines[l].replace(span.begin, span.end - span.begin, round);
          }))
        continue;
      any = true;
      from = span.begin + round.size();
    }
  }

  bool round_hand() {
    if (!best_.hand) return false;
    bool any = false;
    using Place = double& (*)(Hand&);
    constexpr std::array<Place, 6> kPlaces = {
        [](Hand& hand) -> double& { return hand.centre_m.x(); },
        [](Hand& hand) -> double& { return hand.centre_m.y(); },
        [](Hand& hand) -> double& { return hand.centre_m.z(); },
        [](Hand& hand) -> double& { return hand.depth_m; },
        [](Hand& hand) -> double& { return hand.amplitude_m; },
        [](Hand& hand) -> double& { return hand.period_s; }};
    for (const int digits : {1, 2})
      for (const Place place : kPlaces)
        any = take([&](LawCase& c) { place(*c.hand) = to_digits(place(*c.hand), digits); }) || any;
    return any;
  }

  LawCase best_;
  bool breaks_ = false;
  double least_excess_ = 0.0;  // a shrunk case breaks its law about as much
  int tries_;
};

}  // namespace

LawCase shrink(const LawCase& law_case, int tries) {
  return Shrinker(law_case, tries).run();
}

}  // namespace stillgrid::laws
