// A subscriber of another implementation of DDS, Fast DDS, with the names, types and profiles of a
// ROS 2 node: rmw_fastrtps makes the same calls. What it decodes is written here by hand from the
// definitions of ROS, not from our IDL.
//
//   ros_subscriber_fastdds DOMAIN default|sensor_data POSE_TOPIC WRENCH_TOPIC
//
// Where it looks says the profile in $FASTRTPS_DEFAULT_PROFILES_FILE, as for a node: docs/ros.md
// has one for the loopback. Prints a line of JSON for each publisher that it discovers and for each
// message, until it is told to end.
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fastdds/dds/core/status/StatusMask.hpp>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <functional>
#include <string>
#include <utility>

namespace stillgrid::network {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

/// A message of ROS that is a header and then plain doubles, as PoseStamped and WrenchStamped are.
template <std::size_t N>
struct Message {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  std::string frame_id;
  std::array<double, N> values{};
};

/// Decodes Message<N> out of the first encoding, little-endian, as ROS sends it; refuses any other
/// and whatever has bytes left over.
template <std::size_t N>
class MessageType : public dds::TopicDataType {
 public:
  explicit MessageType(const char* name) {
    setName(name);
    m_typeSize = 512;
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }

  bool serialize(void* /*data*/, rtps::SerializedPayload_t* /*payload*/) override { return false; }

  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    constexpr std::uint32_t kLongestPadding = 3;
    if (payload->length < 4 || payload->data[0] != 0 || payload->data[1] != 1) return false;
    auto& message = *static_cast<Message<N>*>(data);
    try {
      eprosima::fastcdr::FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->length);
      eprosima::fastcdr::Cdr cdr(buffer, eprosima::fastcdr::Cdr::DEFAULT_ENDIAN,
                                 eprosima::fastcdr::Cdr::DDS_CDR);
      cdr.read_encapsulation();
      cdr >> message.sec >> message.nanosec >> message.frame_id >> message.values;
      return payload->length - cdr.getSerializedDataLength() <= kLongestPadding;
    } catch (const eprosima::fastcdr::exception::Exception&) {
      return false;
    }
  }

  std::function<std::uint32_t()> getSerializedSizeProvider(void* /*data*/) override {
    return [this] { return m_typeSize; };
  }
  void* createData() override { return new Message<N>; }
  void deleteData(void* data) override { delete static_cast<Message<N>*>(data); }
  bool getKey(void* /*data*/, rtps::InstanceHandle_t* /*key*/, bool /*force_md5*/) override {
    return false;
  }
};

std::uint64_t wall_clock_ns() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(now).count());
}

/// Prints what comes on one topic.
template <std::size_t N>
class Printer : public dds::DataReaderListener {
 public:
  explicit Printer(const char* kind) : kind_(kind) {}

  void on_data_available(dds::DataReader* reader) override {
    Message<N> message;
    dds::SampleInfo info;
    while (reader->take_next_sample(&message, &info) ==
           eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK)
      if (info.valid_data) print(message);
  }

 private:
  void print(const Message<N>& message) const {
    std::string values;
    std::array<char, 32> number{};
    for (std::size_t i = 0; i < N; ++i) {
      std::snprintf(number.data(), number.size(), "%s%.17g", i > 0 ? ", " : "", message.values[i]);
      values += number.data();
    }
    constexpr const char* kLine =
        R"({"kind": "%s", "frame": "%s", "stamp": [%d, %u], "received_ns": %llu, "values": [%s]})"
        "\n";
    std::printf(kLine, kind_, message.frame_id.c_str(), message.sec, message.nanosec,
                static_cast<unsigned long long>(wall_clock_ns()), values.c_str());
  }

  const char* kind_;
};

/// Prints what publishers there are, as ros2 topic list finds them.
class Discovery : public dds::DomainParticipantListener {
 public:
  void on_publisher_discovery(dds::DomainParticipant* /*participant*/,
                              rtps::WriterDiscoveryInfo&& found) override {
    if (found.status != rtps::WriterDiscoveryInfo::DISCOVERED_WRITER) return;
    const rtps::WriterProxyData& writer = found.info;
    const auto& user_data = writer.m_qos.m_userData;
    const bool is_reliable = writer.m_qos.m_reliability.kind == dds::RELIABLE_RELIABILITY_QOS;
    const bool is_volatile = writer.m_qos.m_durability.kind == dds::VOLATILE_DURABILITY_QOS;
    constexpr const char* kLine =
        R"({"kind": "publisher", "topic": "%s", "type": "%s", "reliable": %s, "volatile": %s, )"
        R"("has_type_information": %s, "user_data": "%s"})"
        "\n";
    std::printf(kLine, writer.topicName().c_str(), writer.typeName().c_str(),
                is_reliable ? "true" : "false", is_volatile ? "true" : "false",
                writer.has_type_information() ? "true" : "false",
                std::string(user_data.begin(), user_data.end()).c_str());
  }
};

/// A profile of ROS 2: "default", or "sensor_data".
dds::DataReaderQos reader_qos(const std::string& profile) {
  const bool is_default = profile == "default";
  dds::DataReaderQos qos = dds::DATAREADER_QOS_DEFAULT;
  qos.reliability().kind =
      is_default ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = is_default ? 10 : 5;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.data_sharing().off();
  return qos;
}

template <std::size_t N>
bool subscribe(dds::DomainParticipant& participant, const char* topic, const char* type_name,
               const dds::DataReaderQos& qos, Printer<N>& printer) {
  dds::TypeSupport type(new MessageType<N>(type_name));
  type.register_type(&participant);
  dds::Topic* const made =
      participant.create_topic(topic, type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
  dds::Subscriber* const subscriber =
      participant.create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT, nullptr);
  return made != nullptr && subscriber != nullptr &&
         subscriber->create_datareader(made, qos, &printer) != nullptr;
}

int program_main(char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  sigset_t end_signals;
  sigemptyset(&end_signals);
  sigaddset(&end_signals, SIGINT);
  sigaddset(&end_signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &end_signals, nullptr);  // of the middleware's threads too

  Discovery discovery;
  auto* const factory = dds::DomainParticipantFactory::get_instance();
  if (factory->load_profiles() != eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) return 2;
  const auto domain = static_cast<dds::DomainId_t>(std::strtoul(argv[1], nullptr, 10));
  dds::DomainParticipant* const participant = factory->create_participant(
      domain, factory->get_default_participant_qos(), &discovery, dds::StatusMask::none());
  const dds::DataReaderQos qos = reader_qos(argv[2]);
  Printer<7> poses("pose");
  Printer<6> wrenches("wrench");
  if (participant == nullptr ||
      !subscribe(*participant, argv[3], "geometry_msgs::msg::dds_::PoseStamped_", qos, poses) ||
      !subscribe(*participant, argv[4], "geometry_msgs::msg::dds_::WrenchStamped_", qos, wrenches))
    return 2;
  int number = 0;
  sigwait(&end_signals, &number);
  participant->delete_contained_entities();
  factory->delete_participant(participant);
  return 0;
}

}  // namespace
}  // namespace stillgrid::network

int main(int argc, char** argv) {
  if (argc != 5) return 1;
  return stillgrid::network::program_main(argv);
}
