#include "shared/tools/scene_relay/relay.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "shared/files/json_file.hpp"
#include "shared/publication/segment.hpp"
#include "shared/reading/histogram_json.hpp"
#include "shared/tools/scene_relay/topic_name.hpp"

namespace stillgrid::scene_relay {
namespace {

/// More than any sender counts in kLongestWay_ns.
constexpr std::uint64_t kFurthestLeap = 65'536;
/// Nor is more lost in a silence, of a day: what is further ahead was never counted up to.
constexpr std::uint64_t kMaxLost = std::uint64_t{1} << 33U;

/// Seconds, and how many there were.
nlohmann::json counted_json(const realtime::Histogram& histogram) {
  nlohmann::json result = reading::histogram_json(histogram, 1e-9);
  result["count"] = histogram.count();
  return result;
}

nlohmann::json age_json(const realtime::Histogram& histogram) {
  nlohmann::json result = counted_json(histogram);
  result["over_100_ms"] = histogram.share_above(100'000'000);
  return result;
}

}  // namespace

std::string topic_of(const std::string& session, const char* name) {
  return "stillgrid/" + std::to_string(kProtocol) + "/" + topic_part(session) + "/" + name;
}

std::string greeting_topic(const std::string& session) {
  return "stillgrid/greeting/" + topic_part(session);
}

RelayLink::RelayLink(const RelayOptions& options, Role role, RelayReport& report)
    : report_(report),
      duration_s_(options.duration_s),
      session_(options.session),
      relay_id_(publication::random_epoch()),
      participant_(options.network),
      other_(relay_id_, role, options.session, [](const std::string& line) { spdlog::info(line); }),
      greetings_out_(participant_.writer(stillgrid_Greeting_desc, greeting_topic(session_),
                                         Delivery::kBestEffort)),
      greetings_in_(participant_.reader(stillgrid_Greeting_desc, greeting_topic(session_),
                                        Delivery::kBestEffort, false)),
      status_out_(participant_.writer(stillgrid_relay3_Status_desc,
                                      topic(role == Role::kHand ? "hand" : "simulation"),
                                      Delivery::kBestEffort)),
      status_in_(participant_.reader(stillgrid_relay3_Status_desc,
                                     topic(role == Role::kHand ? "simulation" : "hand"),
                                     Delivery::kBestEffort)) {
  report_.role = role;
  report_.figures.relay_id = relay_id_;
}

bool RelayLink::hear(std::uint64_t now_ns) {
  take_all<Greeting>(greetings_in_, [&](const Greeting& greeting) { other_.hear(greeting); });
  bool is_new = false;
  take_all<Status>(status_in_,
                   [&](const Status& status) { is_new = other_.hear(status, now_ns) || is_new; });
  other_.look(now_ns);
  return is_new;
}

void RelayLink::say(std::uint64_t now_ns, const Said& said) {
  if (now_ns >= next_greeting_ns_) {
    next_greeting_ns_ = now_ns + 1'000'000'000;
    const Greeting greeting = other_.greeting();
    dds_write(greetings_out_, &greeting);
  }
  if (now_ns < next_status_ns_ && said == said_) return;
  said_ = said;
  next_status_ns_ = now_ns + other_.status_period_ns();
  Status status = other_.next_status(now_ns);
  status.segment_epoch = said.segment_epoch;
  status.scene_epoch = said.scene_epoch;
  status.keyframe_id = said.keyframe_id;
  status.received = said.received;
  dds_write(status_out_, &status);
}

bool RelayLink::accept(std::uint64_t relay_id, std::uint64_t number, std::size_t bytes,
                       std::uint64_t now_ns) {
  if (!other_.is_followed(relay_id) || number == 0) return false;
  proto::RelayFigures& figures = report_.figures;
  const bool is_silent = now_ns > accepted_ns_ + kLongestWay_ns;
  if (number_of_ != relay_id || (is_silent && (number < number_ || number - number_ > kMaxLost)))
    number_ = number - 1;
  number_of_ = relay_id;
  if (number <= number_) {
    ++(number == number_ ? figures.repeated : figures.out_of_order);
    return false;
  }
  if (!is_silent && number - number_ > kFurthestLeap) {
    refuse("a message's number leaps ahead");
    return false;
  }
  figures.lost += number - number_ - 1;
  number_ = number;
  accepted_ns_ = now_ns;
  ++figures.received;
  figures.received_bytes += bytes;
  return true;
}

bool RelayLink::came_in_time(std::uint64_t stamp_ns, std::uint64_t now_ns) {
  if (!clock().is_known()) return false;
  const std::uint64_t published_ns = clock().to_ours(stamp_ns);
  const std::uint64_t way_ns = now_ns - std::min(now_ns, published_ns);
  report_.way_ns.record(way_ns);
  // Nothing comes before it was sent: a stamp that lies ahead is no clock's.
  const bool is_ahead = published_ns > now_ns + clock().bound_ns() + 10'000'000;
  if (is_ahead)
    refuse("a stamp lies " + std::to_string((published_ns - now_ns) / 1'000'000) + " ms ahead");
  if (way_ns > kLongestWay_ns) ++report_.figures.late;
  return !is_ahead && way_ns <= kLongestWay_ns;
}

void RelayLink::refuse(const std::string& line) {
  ++report_.figures.refused;
  warn(line);
}

void RelayLink::warn(const std::string& line) {
  if (line == last_warning_) return;
  last_warning_ = line;
  spdlog::warn(line);
}

const proto::RelayFigures& RelayLink::figures() noexcept {
  proto::RelayFigures& figures = report_.figures;
  figures.connected = other_.is_connected() && other_.is_hearing() ? 1 : 0;
  figures.clock_offset_ns = clock().offset_ns();
  figures.clock_bound_ns = clock().bound_ns();
  figures.round_trip_ns = clock().round_trip_ns();
  figures.partitions = other_.partitions();
  figures.longest_silence_ns = other_.longest_silence_ns();
  return figures;
}

void write_report(const RelayReport& report, const std::filesystem::path& file) {
  const proto::RelayFigures& f = report.figures;
  const auto seconds = [](auto ns) { return static_cast<double>(ns) * 1e-9; };
  files::write_json(file, {{"role", report.role == Role::kHand ? "hand" : "simulation"},
                           {"connected", f.connected != 0},
                           {"clock_offset_s", seconds(f.clock_offset_ns)},
                           {"clock_bound_s", seconds(f.clock_bound_ns)},
                           {"round_trip_s", seconds(f.round_trip_ns)},
                           {"received", f.received},
                           {"received_bytes", f.received_bytes},
                           {"lost", f.lost},
                           {"repeated", f.repeated},
                           {"out_of_order", f.out_of_order},
                           {"late", f.late},
                           {"refused", f.refused},
                           {"without_keyframe", report.without_keyframe},
                           {"partitions", f.partitions},
                           {"longest_silence_s", seconds(f.longest_silence_ns)},
                           {"segments", report.segments},
                           {"sent", report.sent},
                           {"sent_bytes", report.sent_bytes},
                           {"keyframes", report.keyframes},
                           {"deltas", report.deltas},
                           {"withheld", report.withheld},
                           {"way_s", counted_json(report.way_ns)},
                           {"age_s", age_json(report.age_ns)}});
}

}  // namespace stillgrid::scene_relay
