#include "daemon/pipeline/drive_reader.hpp"

namespace infuse::daemon {
namespace {

constexpr uint64_t kCaptureOverhead = 58;  // record header, Ethernet, IPv4 and UDP, bytes

}  // namespace

void DriveReader::run(std::stop_token stop) {
  recording::DriveEvent event;
  bool started = false;
  while (!stop.stop_requested() && source_.next(event)) {
    if (!started) intake_.start(event.stamp);
    started = true;
    pacer_.wait_until(event.stamp, stop);
    intake_.advance(event.stamp);
    process(event);
    intake_.push_due_samples(event.stamp);
  }
  intake_.end(event.stamp, started);
}

void DriveReader::process(const recording::DriveEvent& event) {
  if (const auto* datagram = std::get_if<recording::DatagramEvent>(&event.content)) {
    process_datagram(*datagram);
  } else if (const auto* sweep = std::get_if<recording::SweepEvent>(&event.content)) {
    intake_.add_sweep(LidarIndex(sweep->lidar), *sweep->sweep);
  } else if (const auto* image = std::get_if<recording::ImageEvent>(&event.content)) {
    intake_.add_image_file(CameraIndex(image->camera), event.stamp, image->sequence, *image->path);
  } else if (const auto* bus = std::get_if<recording::CanLineEvent>(&event.content)) {
    intake_.add_can_line(bus->line, event.stamp);
  } else if (const auto* speed = std::get_if<WheelOdometry>(&event.content)) {
    intake_.add_speed(*speed, event.stamp);
  } else if (const auto* imu = std::get_if<ImuSample>(&event.content)) {
    intake_.add_imu(*imu, event.stamp);
  } else if (const auto* fix = std::get_if<GnssFix>(&event.content)) {
    intake_.add_gnss(*fix, event.stamp);
  }
}

void DriveReader::process_datagram(const recording::DatagramEvent& event) {
  const Datagram& datagram = event.datagram;
  capture_bytes_.fetch_add(datagram.payload.size() + kCaptureOverhead, std::memory_order_relaxed);
  if (event.lidar == recording::kNoLidar) return intake_.add_unclaimed_datagram(datagram);
  intake_.add_datagram(LidarIndex(event.lidar), datagram);
}

}  // namespace infuse::daemon
