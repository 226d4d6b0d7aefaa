#include "shared/tools/scene_relay/ros_writer.hpp"

#include <memory>
#include <stdexcept>

#include "shared/tools/scene_relay/ros_names.hpp"

namespace stillgrid::scene_relay {
namespace {

using Qos = std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)>;

/// The default profile of ROS 2.
Qos ros_qos(std::string_view type_hash) {
  Qos qos(dds_create_qos(), &dds_delete_qos);
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, 0);
  dds_qset_durability(qos.get(), DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 10);
  dds_qset_writer_data_lifecycle(qos.get(), false);
  const dds_data_representation_id_t encoding = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(qos.get(), 1, &encoding);
  const std::string user_data = "typehash=" + std::string(type_hash) + ";";
  dds_qset_userdata(qos.get(), user_data.data(), user_data.size());
  return qos;
}

dds_entity_t require(dds_entity_t made, const std::string& ros_topic) {
  if (made < 0)
    throw std::runtime_error("cannot publish the topic " + ros_topic + ": " +
                             dds_strretcode(-made));
  return made;
}

}  // namespace

RosWriter::RosWriter(dds_entity_t participant, const std::string& ros_topic,
                     const dds_topic_descriptor_t& type, std::string_view type_hash) {
  const Qos qos = ros_qos(type_hash);
  topic_ =
      require(dds_create_topic(participant, &type, dds_name(ros_topic).c_str(), nullptr, nullptr),
              ros_topic);
  const dds_entity_t writer = dds_create_writer(participant, topic_, qos.get(), nullptr);
  if (writer < 0) dds_delete(topic_);
  writer_ = require(writer, ros_topic);
}

RosWriter::~RosWriter() {
  dds_delete(writer_);
  dds_delete(topic_);
}

bool RosWriter::write(const void* message) const noexcept {
  return dds_write(writer_, message) == DDS_RETCODE_OK;
}

}  // namespace stillgrid::scene_relay
