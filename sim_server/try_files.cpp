#include "sim_server/try_files.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <istream>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>
#include <thread>
#include <vector>

#include "sim_server/dynamics/choice/counted_work.hpp"
#include "sim_server/judge.hpp"
#include "sim_server/scene/build_world.hpp"
#include "sim_server/scene/scene_file.hpp"

namespace stillgrid::sim_server {
namespace {

std::string json_line(const Record& record) {
  nlohmann::ordered_json json = {{"name", record.name},
                                 {"work_per_ms", record.work_per_ms},
                                 {"error_share", nullptr},
                                 {"truth_error_share", record.truth_error_share},
                                 {"latency_share", record.latency_share},
                                 {"spheres", record.spheres},
                                 {"refusal", record.refusal}};
  if (record.error_share) json["error_share"] = *record.error_share;
  return json.dump();
}

Record judged(const Judge& judge, const scene::SceneDescription& given, const std::string& line) {
  Candidate candidate;
  candidate.record.name = line;
  try {
    const std::size_t blank = line.rfind(' ');
    const auto transition = display::transition_named(line.substr(blank + 1));
    if (blank == std::string::npos || !transition)
      throw std::runtime_error("'" + line + "': expected FILE TRANSITION");
    candidate.transition = *transition;
    candidate.scene = scene::load_scene(line.substr(0, blank));
    candidate.scene.hand = given.hand;
    if (candidate.scene.choose_method)
      candidate.scene.method =
          dynamics::choose_method(dynamics::load_of(scene::build_world(candidate.scene)),
                                  candidate.scene.period_s)
              .method;
    return judge.judge(candidate);
  } catch (const std::exception& error) {
    candidate.record.refusal = error.what();
    return candidate.record;
  }
}

}  // namespace

void try_files(const scene::SceneDescription& scene, std::istream& in, std::ostream& out) {
  const Judge judge(scene);
  while (in) {
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line) && !line.empty();) lines.push_back(line);
    std::vector<Record> records(lines.size());
    std::atomic<std::size_t> next = 0;
    {
      std::vector<std::jthread> threads(
          std::min<std::size_t>(lines.size(), std::max(1U, std::thread::hardware_concurrency())));
      for (std::jthread& thread : threads)
        thread = std::jthread([&] {
          for (std::size_t i = next++; i < lines.size(); i = next++)
            records[i] = judged(judge, scene, lines[i]);
        });
    }
    for (const Record& record : records) out << json_line(record) << '\n';
    out.flush();
  }
}

}  // namespace stillgrid::sim_server
