#pragma once

#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/measurement/sweep.hpp"
#include "drivers/recording/pcap_writer.hpp"
#include "drivers/recording/times_csv.hpp"
#include "drivers/ros/messages.hpp"

namespace infuse::importers {

/// Messages that could not be taken, and the reason of the first.
class SkipCount {
 public:
  void add(const std::string& reason) {
    if (count_++ == 0) reason_ = reason;
  }
  /// Appends a note if there were any.
  void append_notes(const std::string& topic, std::vector<Error>& notes) const {
    if (count_ == 0) return;
    notes.push_back(
        {std::to_string(count_) + " messages are skipped; the first " + reason_, topic, ""});
  }

 private:
  size_t count_ = 0;
  std::string reason_;
};

/// Writes the packets of one lidar to a capture, in order of time: data packets of scans, and
/// packets of other kinds, which come between scans.
class PacketSink {
 public:
  static Result<PacketSink> create(const std::filesystem::path& path);

  /// Adds a packet: a data packet is written behind those that wait, others where they come.
  Result<void> add(std::span<const uint8_t> payload, Stamp stamp);
  /// Adds a packet of information or of the inertial unit from another topic, which waits for data
  /// packets before it; others are counted as skipped.
  Result<void> add_position(std::span<const uint8_t> payload, Stamp log_time);
  Result<void> finish();

  size_t packets() const { return packets_; }
  bool has_positions() const { return has_positions_; }
  /// What is beside the capture: the unit's metadata; empty: nothing.
  void set_calibration(std::string file) { calibration_ = std::move(file); }
  const std::string& calibration() const { return calibration_; }
  /// The model that the packets are of; null if that is not clear.
  const lidar::LidarModel* model() const {
    return inference_ != nullptr ? inference_->judge() : nullptr;
  }
  SkipCount skipped;

 private:
  struct Position {
    Stamp stamp;
    std::vector<uint8_t> payload;
  };
  explicit PacketSink(recording::PcapWriter writer) : writer_(std::move(writer)) {}
  void infer(std::span<const uint8_t> payload);
  Result<void> write(Stamp stamp, uint16_t port, std::span<const uint8_t> payload);
  Result<void> write_positions(Stamp until);

  recording::PcapWriter writer_;
  std::deque<Position> positions_;                    ///< that wait for the packets before them
  std::unique_ptr<lidar::ModelInference> inference_;  ///< null before the first data packet
  size_t packets_ = 0;
  bool has_positions_ = false;
  std::string calibration_;
};

/// Writes the clouds of one lidar as sweeps.
class CloudSink {
 public:
  static Result<CloudSink> create(const std::filesystem::path& folder);

  Result<void> add(const ros::PointCloud2& cloud, Stamp stamp);
  Result<void> finish();

  size_t sweeps() const { return rows_.size(); }
  size_t without_times() const { return without_times_; }
  SkipCount skipped;

 private:
  explicit CloudSink(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::filesystem::path folder_;
  std::vector<recording::TimesRow> rows_;
  size_t without_times_ = 0;
  Sweep sweep_;
};

/// Writes the images of one camera: compressed ones as they are, others as PNG.
class ImageSink {
 public:
  /// Images of other sizes than `intrinsics` are skipped.
  static Result<ImageSink> create(const std::filesystem::path& folder,
                                  const CameraIntrinsics& intrinsics);

  Result<void> add(const ros::CompressedImage& image, Stamp stamp);
  Result<void> add(const ros::Image& image, Stamp stamp);
  Result<void> finish();

  size_t images() const { return stamps_.size(); }
  std::optional<PixelFormat> mosaic() const { return mosaic_; }
  SkipCount skipped;

 private:
  ImageSink(std::filesystem::path folder, int width, int height)
      : folder_(std::move(folder)), width_(width), height_(height) {}
  Result<void> write(std::span<const uint8_t> file, const char* extension, Stamp stamp);

  std::filesystem::path folder_;
  int width_, height_;
  std::vector<Stamp> stamps_;
  std::optional<PixelFormat> mosaic_;
  CameraFrame frame_;
};

}  // namespace infuse::importers
