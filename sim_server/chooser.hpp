#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "sim_server/dynamics/choice/counted_work.hpp"
#include "sim_server/judge.hpp"

namespace stillgrid::sim_server {

/// Counted work that a choice may spend: 10 s of a processor at a start, 15 s for --explain.
inline constexpr double kStartWork = 1e4 * dynamics::kWorkPerProcessor_ms;
inline constexpr double kExplainWork = 1.5 * kStartWork;
inline constexpr double kUnlimitedWork = std::numeric_limits<double>::infinity();

/// Returns rates from 10 Hz to 1 kHz for a scene with rate_hz = "auto". Other scenes have their
/// own. `all` adds those rates for a scene that names one, and both methods at the scene's rate.
[[nodiscard]] std::vector<Candidate> candidates_of(const scene::SceneDescription& scene, bool all);

/// A choice among candidates.
struct Choice {
  std::vector<choice::Record> records;
  Candidate chosen;
  choice::Limits limits;
  double truth_error_share = 0.0, watched_s = 0.0;
};

/// Judges the candidates in their order until most_work is spent, and chooses one within
/// scene.processor_share. report: called with a line of progress. Throws as Judge. Pre: scene.hand;
/// candidates not empty.
[[nodiscard]] Choice choose(const scene::SceneDescription& scene, std::vector<Candidate> candidates,
                            double most_work,
                            const std::function<void(const std::string&)>& report);

/// Returns the limit that a choice misses or an error that is unknown, in words; empty: it keeps
/// all.
[[nodiscard]] std::string complaint_of(const Choice& choice);

}  // namespace stillgrid::sim_server
