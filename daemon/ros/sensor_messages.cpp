#include "daemon/ros/sensor_messages.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "drivers/ros/sweep_cloud.hpp"

namespace infuse::daemon {
namespace {

ros::Header header_of(Stamp stamp, const std::string& frame) {
  return {0, ros::Time::from(stamp), frame};
}

/// As image_transport writes it: what was compressed, if that is not the usual.
std::string format_of(const SensorMessages::ImageBytes& image) {
  std::string file = image.png ? "png" : "jpeg";
  if (!image.mosaic) return file;
  const char* name = *image.mosaic == PixelFormat::kBayerRggb8   ? "bayer_rggb8"
                     : *image.mosaic == PixelFormat::kBayerBggr8 ? "bayer_bggr8"
                     : *image.mosaic == PixelFormat::kBayerGbrg8 ? "bayer_gbrg8"
                                                                 : "bayer_grbg8";
  return std::string(name) + "; " + file + " compressed " + name;
}

ros::CameraInfo info_of(const CameraIntrinsics& c, const ros::Header& header) {
  ros::CameraInfo info{.header = header};
  info.width = static_cast<uint32_t>(c.width);
  info.height = static_cast<uint32_t>(c.height);
  const bool fisheye = c.model == CameraIntrinsics::Model::kFisheye;
  info.distortion_model = fisheye ? "equidistant" : "plumb_bob";
  info.d.assign(c.distortion.begin(), c.distortion.begin() + (fisheye ? 4 : 5));
  info.k = {c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1};
  info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.p = {c.fx, 0, c.cx, 0, 0, c.fy, c.cy, 0, 0, 0, 1, 0};
  return info;
}

}  // namespace

SensorMessages::SensorMessages(MessageSetup setup, MessageSink& sink)
    : setup_(std::move(setup)), sink_(sink), scans_(setup_.rig.lidars.size()) {
  for (const LidarMount& lidar : rig_.lidars) lidar_topics_.emplace_back(lidar.name);
  for (const CameraMount& camera : rig_.cameras) camera_topics_.emplace_back(camera.name);
}

std::map<std::string, std::string> SensorMessages::metadata() const {
  std::map<std::string, std::string> pairs;
  for (const char* topic : kEstimateTopics) pairs[std::string("estimate ") + topic] = "of infuse";
  for (size_t k = 0; k < rig_.cameras.size(); ++k) {
    pairs["stamp_delay_sigma_ns " + camera_topics_[k].image] =
        std::to_string(rig_.cameras[k].stamp_delay_sigma.count());
    pairs["readout_ns " + camera_topics_[k].image] =
        std::to_string(rig_.cameras[k].readout.count());
  }
  if (setup_.gnss_lidar) pairs["gnss_lidar"] = rig_.lidars[*setup_.gnss_lidar].name;
  return pairs;
}

void SensorMessages::write_constants(Stamp stamp) {
  write_transforms(stamp);
  for (size_t k = 0; k < lidar_topics_.size(); ++k) {
    if (setup_.packet_metadata[k].empty()) continue;
    sink_.write(lidar_topics_[k].metadata, stamp, ros::String{setup_.packet_metadata[k]}, true);
  }
}

void SensorMessages::write_transforms(Stamp stamp) {
  ros::TfMessage message;
  for (size_t k = 0; k < rig_.lidars.size(); ++k) {
    if (!rig_.lidars[k].is_mounting_known()) continue;
    message.transforms.push_back({header_of(stamp, kVehicleFrame), lidar_frame(rig_, k),
                                  ros::to_transform(rig_.lidars[k].T_vehicle_lidar)});
  }
  for (size_t k = 0; k < rig_.cameras.size(); ++k) {
    const CameraMount& camera = rig_.cameras[k];
    const auto lidar = std::ranges::find(rig_.lidars, camera.lidar, &LidarMount::name);
    if (lidar == rig_.lidars.end()) continue;
    const auto index = static_cast<size_t>(lidar - rig_.lidars.begin());
    message.transforms.push_back({header_of(stamp, lidar_frame(rig_, index)), camera_frame(rig_, k),
                                  ros::to_transform(camera.T_camera_lidar.inverse())});
  }
  // A fix is taken as of the vehicle's origin: the rig has no position of an antenna.
  if (setup_.has_gnss || setup_.gnss_lidar) {
    message.transforms.push_back({header_of(stamp, kVehicleFrame), kGnssFrame,
                                  ros::to_transform(Eigen::Isometry3d::Identity())});
  }
  if (!message.transforms.empty()) sink_.write(kTransformsTopic, stamp, message, true);
}

void SensorMessages::add_datagram(size_t lidar, std::span<const uint8_t> payload, Stamp stamp) {
  const lidar::LidarMaker* maker = setup_.packet_makers[lidar];
  if (maker == nullptr) return;  // its sweeps are written
  const lidar::PacketClass packet_class = maker->classify(payload);
  if (packet_class == lidar::PacketClass::kOther) {
    ++other_datagrams_;
    return;
  }
  const LidarTopics& topics = lidar_topics_[lidar];
  const bool data = packet_class == lidar::PacketClass::kData;
  switch (maker->ros_packets()) {
    case lidar::RosPackets::kVelodyneScan:
    case lidar::RosPackets::kPandarScan:
      return data ? add_to_scan(lidar, payload, stamp) : write_bytes(lidar, payload, stamp);
    case lidar::RosPackets::kRslidarPacket:
      return sink_.write(topics.packets, stamp,
                         ros::RslidarPacket{header_of(stamp, lidar_frame(rig_, lidar)),
                                            static_cast<uint8_t>(data ? 0 : 1), 0, payload});
    case lidar::RosPackets::kOusterPacket:
      return sink_.write(data ? topics.packets : topics.position_packets, stamp,
                         ros::OusterPacket{payload});
    case lidar::RosPackets::kNone:
      break;
  }
}

void SensorMessages::write_bytes(size_t lidar, std::span<const uint8_t> payload, Stamp stamp) {
  const auto size = static_cast<uint32_t>(payload.size());
  const ros::UInt8MultiArray bytes{{{"bytes", size, size}}, 0, payload};
  sink_.write(lidar_topics_[lidar].position_packets, stamp, bytes);
}

void SensorMessages::add_to_scan(size_t lidar, std::span<const uint8_t> payload, Stamp stamp) {
  if (!sink_.wants(lidar_topics_[lidar].packets)) return scans_[lidar].clear();
  const uint16_t azimuth = setup_.packet_makers[lidar]->first_azimuth(payload);
  if (scans_[lidar].is_due(azimuth, stamp)) write_scan(lidar);
  scans_[lidar].add(payload, azimuth, stamp);
}

void SensorMessages::write_scan(size_t lidar) {
  const Stamp end = scans_[lidar].end();
  const std::string& topic = lidar_topics_[lidar].packets;
  const std::string frame = lidar_frame(rig_, lidar);
  if (setup_.packet_makers[lidar]->ros_packets() == lidar::RosPackets::kPandarScan) {
    return sink_.write(topic, end, scans_[lidar].finish<ros::PandarScan>(frame));
  }
  sink_.write(topic, end, scans_[lidar].finish<ros::VelodyneScan>(frame));
}

void SensorMessages::write_sweep(size_t lidar, const Sweep& sweep, Stamp log_time) {
  const LidarTopics& topics = lidar_topics_[lidar];
  const std::string& topic = sweep.deskewed ? topics.points : topics.points_raw;
  if (!sink_.wants(topic)) return;
  sink_.write(topic, log_time, ros::to_cloud(sweep, lidar_frame(rig_, lidar), data_));
}

void SensorMessages::write_deskewed(size_t lidar, Sweep& sweep, Stamp reference) {
  const std::string& topic = lidar_topics_[lidar].points;
  if (!sink_.wants(topic)) return;
  sweep.stamp = reference;
  sweep.has_times = false;
  sink_.write(topic, reference, ros::to_cloud(sweep, lidar_frame(rig_, lidar), data_));
}

void SensorMessages::write_image(size_t camera, const ImageBytes& image, Stamp stamp) {
  const CameraTopics& topics = camera_topics_[camera];
  const ros::Header header = header_of(stamp, camera_frame(rig_, camera));
  if (sink_.wants(topics.image)) {
    ros::CompressedImage message{.header = header};
    message.format = format_of(image);
    message.data = image.bytes;
    sink_.write(topics.image, stamp, message);
  }
  sink_.write(topics.info, stamp, info_of(rig_.cameras[camera].intrinsics, header));
}

void SensorMessages::write_sample(const VehicleSample& sample, bool from_bus) {
  if (const auto* wheels = std::get_if<WheelOdometry>(&sample)) write_wheels(*wheels, from_bus);
  if (const auto* imu = std::get_if<ImuSample>(&sample)) write_imu(*imu, from_bus);
  if (const auto* fix = std::get_if<GnssFix>(&sample)) write_fix(*fix);
}

void SensorMessages::write_wheels(const WheelOdometry& sample, bool from_bus) {
  ros::TwistWithCovarianceStamped message{header_of(sample.stamp, kVehicleFrame), {}, {}};
  const double rear = (sample.wheel_speed[2] + sample.wheel_speed[3]) / 2;
  const bool by_wheels = !std::isfinite(sample.speed);
  const double speed = by_wheels ? rear : sample.speed;
  if (by_wheels && std::isfinite(rear)) ++wheel_samples_;
  if (!std::isfinite(speed) && !std::isfinite(sample.yaw_rate)) return;
  // What is not measured is 0, with a variance of -1; so are the motions sideways, up, and of roll
  // and pitch.
  for (const size_t axis : {1, 2, 3, 4}) message.covariance[7 * axis] = -1;
  const auto set = [](double measured, double& component, double& variance) {
    const bool known = std::isfinite(measured);
    component = known ? measured : 0;
    variance = known ? 0 : -1;
  };
  set(speed, message.twist.linear.x, message.covariance.front());
  set(sample.yaw_rate, message.twist.angular.z, message.covariance.back());
  sink_.write(vehicle_topic(from_bus) + "/twist", sample.stamp, message);
}

void SensorMessages::write_imu(const ImuSample& sample, bool from_bus) {
  ros::Imu message{.header = header_of(sample.stamp, kVehicleFrame)};
  message.orientation_covariance[0] = -1;  // not measured
  const auto& w = sample.angular_velocity;
  const auto& a = sample.linear_acceleration;
  // What is not measured is marked by a covariance that begins with -1, and is 0.
  const auto set = [](const auto& measured, auto& vector, std::array<double, 9>& covariance) {
    const bool known = std::ranges::all_of(measured, [](double v) { return std::isfinite(v); });
    if (known) vector = {measured[0], measured[1], measured[2]};
    if (!known) covariance[0] = -1;
  };
  set(w, message.angular_velocity, message.angular_velocity_covariance);
  set(a, message.linear_acceleration, message.linear_acceleration_covariance);
  sink_.write(vehicle_topic(from_bus) + "/imu", sample.stamp, message);
}

void SensorMessages::write_fix(const GnssFix& fix) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  ros::NavSatFix message{.header = header_of(fix.stamp, kGnssFrame)};
  message.status = static_cast<int8_t>(fix.valid ? 0 : -1);
  message.service = 1;
  message.latitude = fix.latitude * kDegrees;
  message.longitude = fix.longitude * kDegrees;
  message.altitude = fix.altitude;
  sink_.write("/gnss/fix", fix.stamp, message);
  write_velocity(fix);
}

/// As ROS drivers of GNSS receivers publish it: to the east and north, beside the fix.
void SensorMessages::write_velocity(const GnssFix& fix) {
  const bool stationary = fix.speed == 0;
  if (!std::isfinite(fix.speed)) return;
  if (!stationary && !std::isfinite(fix.course)) {
    ++speeds_without_course_;
    return;
  }
  ros::TwistStamped message{header_of(fix.stamp, kGnssFrame), {}};
  message.twist.linear.x = stationary ? 0 : fix.speed * std::sin(fix.course);
  message.twist.linear.y = stationary ? 0 : fix.speed * std::cos(fix.course);
  sink_.write("/gnss/vel", fix.stamp, message);
}

void SensorMessages::finish() {
  for (size_t k = 0; k < scans_.size(); ++k) {
    if (!scans_[k].empty()) write_scan(k);
  }
}

void SensorMessages::append_notes(std::vector<Error>& notes) const {
  const auto note = [&](size_t count, const char* what) {
    if (count > 0) notes.push_back({std::to_string(count) + " " + what, "", ""});
  };
  note(other_datagrams_, "datagrams are not written: they are of no lidar, or of another length");
  note(speeds_without_course_, "speeds of GNSS are not written: they have no course");
  note(wheel_samples_, "samples of wheels are written as the speed of the rear axle");
}

}  // namespace infuse::daemon
