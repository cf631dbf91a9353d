#include "daemon/ros/lcm_publisher.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstring>

#include "daemon/ros/topics.hpp"
#include "drivers/lcm/lcm_types.hpp"
#include "drivers/ros/messages.hpp"

namespace infuse::daemon {
namespace {

int64_t microseconds(const ros::Header& header) { return header.stamp.stamp().ns() / 1000; }

/// A column of a cloud: every `step`-th value of the field; empty if there is no such field.
template <class Value, class Out>
void copy_field(const ros::PointCloud2& cloud, const char* name, size_t step,
                std::vector<Out>& out) {
  const auto field = std::ranges::find(cloud.point_fields, name, &ros::PointField::name);
  if (field == cloud.point_fields.end()) return;
  for (size_t k = 0; k < cloud.width; k += step) {
    const size_t at = k * cloud.point_step + field->offset;
    if (at + sizeof(Value) > cloud.data.size()) return;
    Value value;
    std::memcpy(&value, cloud.data.data() + at, sizeof value);
    out.push_back(static_cast<Out>(value));
  }
}

std::string value_of(const ros::DiagnosticStatus& status, const char* key) {
  const auto found = std::ranges::find(status.values, key, &ros::KeyValue::key);
  return found == status.values.end() ? std::string() : found->value;
}

}  // namespace

Result<std::unique_ptr<LcmPublisher>> LcmPublisher::create(const LcmSettings& settings,
                                                           const MessageSetup& setup) {
  auto sender = lcm::LcmSender::open(settings.to);
  if (!sender) return tl::unexpected(sender.error());
  return std::unique_ptr<LcmPublisher>(new LcmPublisher(*std::move(sender), settings, setup));
}

LcmPublisher::LcmPublisher(lcm::LcmSender sender, const LcmSettings& settings,
                           const MessageSetup& setup)
    : sender_(std::move(sender)), max_points_(settings.max_points) {
  const auto add_output = [&](const std::string& topic, Kind kind, const std::string& channel,
                              const std::string& name) {
    constexpr size_t kMaxChannel = 63;
    topics_[topic] = {kind, (settings.prefix + "_" + channel).substr(0, kMaxChannel), name};
  };
  for (const char* frame : {"odom", "map"})
    add_output(std::string("/odometry/") + frame, Kind::kPose, std::string("POSE_") + frame, "");
  add_output(kDiagnosticsTopic, Kind::kAlert, "ALERT", "");
  if (settings.sweeps == "none") return;
  for (const LidarMount& lidar : setup.rig.lidars) {
    const LidarTopics topics(lidar.name);
    add_output(settings.sweeps == "measured" ? topics.points_raw : topics.points, Kind::kSweep,
               "SWEEP_" + lidar.name, lidar.name);
  }
}

void LcmPublisher::add(const std::string& topic, const char*, Stamp, bool,
                       std::span<const uint8_t> bytes) {
  const auto found = topics_.find(topic);
  if (found == topics_.end()) return;
  switch (found->second.kind) {
    case Kind::kPose:
      return add_pose(found->second, bytes);
    case Kind::kSweep:
      return add_sweep(found->second, bytes);
    case Kind::kAlert:
      return add_alerts(found->second, bytes);
  }
}

void LcmPublisher::add_pose(const Output& output, std::span<const uint8_t> bytes) {
  const auto pose = ros::decode<ros::Odometry>(bytes, ros::Encoding::kCdr);
  if (!pose) return;
  const ros::Vector3& t = pose->pose.translation;
  const ros::Quaternion& q = pose->pose.rotation;
  send(output.channel, lcm::PoseMessage{.utime = microseconds(pose->header),
                                        .frame = pose->header.frame_id,
                                        .position = {t.x, t.y, t.z},
                                        .orientation = {q.w, q.x, q.y, q.z},
                                        .covariance = pose->pose_covariance,
                                        .speed = pose->twist.linear.x,
                                        .yaw_rate = pose->twist.angular.z});
}

void LcmPublisher::add_sweep(const Output& output, std::span<const uint8_t> bytes) {
  const auto cloud = ros::decode<ros::PointCloud2>(bytes, ros::Encoding::kCdr);
  if (!cloud) return;
  lcm::SweepMessage sweep{.utime = microseconds(cloud->header), .lidar = output.name};
  sweep.deskewed = std::ranges::find(cloud->point_fields, "t", &ros::PointField::name) ==
                   cloud->point_fields.end();
  const size_t step = std::max<size_t>(1, (cloud->width + max_points_ - 1) / max_points_);
  copy_field<float>(*cloud, "x", step, sweep.x);
  copy_field<float>(*cloud, "y", step, sweep.y);
  copy_field<float>(*cloud, "z", step, sweep.z);
  copy_field<float>(*cloud, "intensity", step, sweep.reflectivity);
  copy_field<uint16_t>(*cloud, "ring", step, sweep.ring);
  send(output.channel, sweep);
}

// Statuses of HEALTH have no state.
void LcmPublisher::add_alerts(const Output& output, std::span<const uint8_t> bytes) {
  const auto array = ros::decode<ros::DiagnosticArray>(bytes, ros::Encoding::kCdr);
  if (!array) return;
  for (const ros::DiagnosticStatus& status : array->status) {
    const std::string state = value_of(status, "state");
    if (state != "raised" && state != "cleared") continue;
    send(output.channel, lcm::AlertMessage{.utime = microseconds(array->header),
                                           .id = value_of(status, "id"),
                                           .device = status.hardware_id,
                                           .severity = value_of(status, "severity"),
                                           .state = state,
                                           .what = status.message,
                                           .advice = value_of(status, "advice")});
  }
}

template <class Message>
void LcmPublisher::send(const std::string& channel, const Message& message) {
  lcm::encode(message, payload_);
  const auto done = sender_.send(channel, payload_);
  ++(done ? sent_ : failed_);
  if (!done && !std::exchange(said_, true)) spdlog::warn("{}", done.error().message());
}

}  // namespace infuse::daemon
