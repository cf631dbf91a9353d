#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/pipeline/vehicle_sample.hpp"
#include "daemon/ros/message_setup.hpp"
#include "daemon/ros/message_sink.hpp"
#include "daemon/ros/scan_builder.hpp"
#include "daemon/ros/topics.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::daemon {

/// Writes what the sensors measure as messages of ROS 2; the topics are listed in the README. The
/// log time of a message is the time at which it was there, its header's stamp that of measurement.
class SensorMessages {
 public:
  /// An image of a camera.
  struct ImageBytes {
    std::span<const uint8_t> bytes;       ///< a JPEG or PNG file
    bool png = false;                     ///< else JPEG
    std::optional<PixelFormat> mosaic{};  ///< the file is grey and holds a Bayer mosaic
  };

  /// `sink` outlives this.
  SensorMessages(MessageSetup setup, MessageSink& sink);
  SensorMessages(const SensorMessages&) = delete;
  SensorMessages& operator=(const SensorMessages&) = delete;

  /// Text pairs that the messages have no place for.
  std::map<std::string, std::string> metadata() const;

  /// What holds for all of a run: the sensors' mounts, and the metadata of lidars' packets.
  void write_constants(Stamp stamp);
  /// Other datagrams than packets are counted; packets for which there is no message are not
  /// written.
  void add_datagram(size_t lidar, std::span<const uint8_t> payload, Stamp stamp);
  /// A sweep as measured, or as its source has deskewed it.
  void write_sweep(size_t lidar, const Sweep& sweep, Stamp log_time);
  /// A sweep whose returns are as of `reference`, which becomes its stamp.
  void write_deskewed(size_t lidar, Sweep& sweep, Stamp reference);
  void write_image(size_t camera, const ImageBytes& image, Stamp stamp);
  /// `from_bus`: it is decoded from a bus, not from a sensor of its own.
  void write_sample(const VehicleSample& sample, bool from_bus);
  void write_fix(const GnssFix& fix);

  /// Writes the scans that were not complete.
  void finish();
  /// Counts a datagram that is of no lidar.
  void count_other_datagram() { ++other_datagrams_; }
  /// Appends what was not written.
  void append_notes(std::vector<Error>& notes) const;

 private:
  void write_transforms(Stamp stamp);
  void add_to_scan(size_t lidar, std::span<const uint8_t> payload, Stamp stamp);
  void write_scan(size_t lidar);
  void write_bytes(size_t lidar, std::span<const uint8_t> payload, Stamp stamp);
  void write_wheels(const WheelOdometry& sample, bool from_bus);
  void write_imu(const ImuSample& sample, bool from_bus);
  void write_velocity(const GnssFix& fix);

  const MessageSetup setup_;
  const Rig& rig_ = setup_.rig;
  MessageSink& sink_;
  std::vector<LidarTopics> lidar_topics_;
  std::vector<CameraTopics> camera_topics_;
  std::vector<ScanBuilder> scans_;
  std::vector<uint8_t> data_;
  size_t other_datagrams_ = 0, wheel_samples_ = 0, speeds_without_course_ = 0;
};

}  // namespace infuse::daemon
