#include "shared/tools/scene_relay/ros_names.hpp"

#include <catch2/catch.hpp>
#include <stdexcept>

namespace stillgrid::scene_relay::ros_names_test {
namespace {

std::string refusal_of(const std::string& session) {
  try {
    (void)ros_names(session);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

TEST_CASE("A session's tool has the names that a ROS 2 user types", "[ros_names]") {
  const RosNames names = ros_names("Demo_2");
  CHECK(names.pose_topic == "/stillgrid/Demo_2/tool_pose");
  CHECK(names.wrench_topic == "/stillgrid/Demo_2/tool_wrench");
  CHECK(names.frame == "stillgrid/Demo_2");
  CHECK(dds_name(names.pose_topic) == "rt/stillgrid/Demo_2/tool_pose");
}

TEST_CASE("Hands of a session have topics of their own in one frame", "[ros_names]") {
  const RosNames left = ros_names("demo+left"), right = ros_names("demo+right");
  CHECK(left.pose_topic == "/stillgrid/demo/left/tool_pose");
  CHECK(left.wrench_topic == "/stillgrid/demo/left/tool_wrench");
  CHECK(right.pose_topic == "/stillgrid/demo/right/tool_pose");
  CHECK(left.frame == "stillgrid/demo");
  CHECK(right.frame == left.frame);
}

TEST_CASE("Another user's session has the name that it has for that user", "[ros_names]") {
  CHECK(ros_names("1000/demo+left").pose_topic == ros_names("demo+left").pose_topic);
  CHECK(ros_names("1000/demo").frame == "stillgrid/demo");
}

TEST_CASE("A name that ROS refuses is refused in a line that says which", "[ros_names]") {
  for (const char* session : {"a-b", "a.b", "2nd", "-", "1000/2nd"}) {
    const std::string line = refusal_of(session);
    CHECK_THAT(line, Catch::StartsWith("--session: value '"));
    CHECK(line.find('\n') == std::string::npos);
  }
  CHECK_THAT(refusal_of("demo+c-3"), Catch::StartsWith("--hand: value 'c-3'"));
  CHECK_THAT(refusal_of("demo+1st"), Catch::StartsWith("--hand: value '1st'"));
  CHECK(refusal_of("_").empty());
}

}  // namespace
}  // namespace stillgrid::scene_relay::ros_names_test
