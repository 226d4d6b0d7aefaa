#pragma once

#include <dds/dds.h>

#include <atomic>
#include <cstdint>
#include <string>

#include "shared/tools/scene_relay/ros_source.hpp"

namespace stillgrid::scene_relay {

struct RosOptions {
  std::string session;      // NAME or NAME+HAND, as settle_hand_session() leaves it
  double rate_hz = 1000.0;  // at most so many messages a second on each topic
};

/// What came of a run.
struct RosFigures {
  RosCounts counts;
  std::uint64_t published = 0;  // states, each on both topics
  std::uint64_t unsent = 0;     // that the middleware took no message of, or not both
};

/// Publishes a hand's tool as ROS 2 would until stop: pose and wrench (docs/ros.md), one message of
/// each for a state of the tool. It only reads the segment, waits for a haptic_server that is not
/// there yet, and keeps to the next one. What it publishes under, and each refusal of a segment
/// once, is logged.
///
/// participant: whoever it lets in gets the messages. Throws std::invalid_argument where the
/// session has no ROS name, SegmentError as require_hand(), std::runtime_error where a topic cannot
/// be made.
RosFigures run_ros_topics(dds_entity_t participant, const RosOptions& options,
                          const std::atomic<bool>& stop);

}  // namespace stillgrid::scene_relay
