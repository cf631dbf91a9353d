#include "daemon/commands/mcap_export.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>

#include "daemon/commands/deskewed_sweeps.hpp"
#include "daemon/commands/report_messages.hpp"
#include "daemon/commands/ros_file.hpp"
#include "daemon/pipeline/drive_setup.hpp"
#include "daemon/pipeline/lidar_intake.hpp"
#include "daemon/pipeline/vehicle_intake.hpp"
#include "drivers/mcap/mcap_reader.hpp"
#include "drivers/recording/mapped_file.hpp"
#include "drivers/ros/messages.hpp"
#include "drivers/ros/sweep_cloud.hpp"
#include "drivers/text/text_file.hpp"
#include "drivers/velodyne/packet.hpp"
#include "drivers/velodyne/position_packet.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kVehicleFrame = "base_link";
constexpr size_t kMaxImageBytes = size_t{64} << 20;

std::string lidar_topic(const Rig& rig, size_t lidar) { return "/lidar/" + rig.lidars[lidar].name; }
std::string camera_topic(const Rig& rig, size_t k) { return "/camera/" + rig.cameras[k].name; }
std::string image_topic(const Rig& rig, size_t k) {
  return camera_topic(rig, k) + "/image_raw/compressed";
}
std::string lidar_frame(const Rig& rig, size_t lidar) { return "lidar_" + rig.lidars[lidar].name; }
std::string camera_frame(const Rig& rig, size_t k) { return "camera_" + rig.cameras[k].name; }

ros::Header header_of(Stamp stamp, const std::string& frame) {
  return {0, ros::Time::from(stamp), frame};
}

/// Collects the data packets of a lidar to scans of a turn.
class ScanBuilder {
 public:
  /// True if the packet begins a new turn, or the scan is long enough.
  bool is_due(std::span<const uint8_t> payload, Stamp stamp) const {
    constexpr size_t kMaxPackets = 2000;
    constexpr Duration kMaxSpan{500'000'000};
    if (packets_.empty()) return false;
    const Duration span = stamp - packets_.front().stamp.stamp();
    return azimuth_of(payload) < azimuth_of(packets_.back().data) ||
           packets_.size() >= kMaxPackets || span > kMaxSpan || span < Duration::zero();
  }
  void add(std::span<const uint8_t> payload, Stamp stamp) {
    ros::VelodynePacket& packet = packets_.emplace_back();
    packet.stamp = ros::Time::from(stamp);
    std::ranges::copy(payload, packet.data.begin());
  }
  bool empty() const { return packets_.empty(); }
  /// Time of the last packet.
  Stamp end() const { return packets_.back().stamp.stamp(); }
  /// The packets so far, with the stamp of the first one. Begins a new scan.
  ros::VelodyneScan finish(const std::string& frame) {
    ros::VelodyneScan scan{{0, packets_.front().stamp, frame}, std::move(packets_)};
    packets_.clear();
    return scan;
  }

 private:
  static uint16_t azimuth_of(std::span<const uint8_t> payload) {
    return velodyne::read_u16(payload.data() + 2);
  }
  std::vector<ros::VelodynePacket> packets_;
};

/// Writes the events of a drive.
class DriveExport {
 public:
  DriveExport(const DriveSetup& setup, RosFile& file, bool deskew)
      : setup_(setup), rig_(setup.rig), file_(file), vehicle_(setup.vehicle) {
    scans_.resize(rig_.lidars.size());
    for (size_t k = 0; deskew && k < rig_.lidars.size(); ++k) {
      intakes_.push_back(std::make_unique<LidarIntake>(setup.lidars[k]));
      deskewed_.push_back(
          std::make_unique<DeskewedSweeps>(rig_.lidars[k].T_vehicle_lidar, OdometrySettings{}));
    }
  }

  void write(const recording::DriveEvent& event) {
    if (!started_) write_transforms(event.stamp);
    started_ = true;
    if (const auto* datagram = std::get_if<recording::DatagramEvent>(&event.content)) {
      write_datagram(*datagram);
    } else if (const auto* sweep = std::get_if<recording::SweepEvent>(&event.content)) {
      write_sweep(*sweep->sweep, sweep->lidar, event.stamp);
    } else if (const auto* image = std::get_if<recording::ImageEvent>(&event.content)) {
      write_image(*image, event.stamp);
    } else if (const auto* bus = std::get_if<recording::CanLineEvent>(&event.content)) {
      vehicle_.add_can_line(bus->line, event.stamp,
                            [&](const VehicleSample& sample) { write_sample(sample, "/bus"); });
    } else if (const auto* speed = std::get_if<WheelOdometry>(&event.content)) {
      write_sample(*speed, "");
    } else if (const auto* imu = std::get_if<ImuSample>(&event.content)) {
      write_sample(*imu, "");
    } else if (const auto* fix = std::get_if<GnssFix>(&event.content)) {
      write_sample(*fix, "");
    }
    for (size_t k = 0; k < deskewed_.size(); ++k)
      deskewed_[k]->process_due(event.stamp, deskewed_writer(k));
  }

  void finish(std::vector<Error>& notes) {
    for (size_t k = 0; k < scans_.size(); ++k) {
      if (!scans_[k].empty()) write_scan(k);
    }
    for (size_t k = 0; k < deskewed_.size(); ++k) {
      intakes_[k]->finish([&](Sweep& sweep) { deskewed_[k]->add_sweep(sweep); });
      deskewed_[k]->finish(deskewed_writer(k));
    }
    const auto note = [&](size_t count, const char* what) {
      if (count > 0) notes.push_back({std::to_string(count) + " " + what, "", ""});
    };
    note(other_datagrams_, "datagrams are not written: they are of no lidar, or of another length");
    note(unreadable_images_, "images are not written: they cannot be read");
    note(not_deskewed_, "sweeps are not on .../points: odometry does not cover them");
    note(speeds_without_course_, "speeds of GNSS are not written: they have no course");
    note(wheel_samples_, "samples of wheels are written as the speed of the rear axle");
  }

  void write_metadata() {
    std::map<std::string, std::string> pairs;
    for (size_t k = 0; k < rig_.cameras.size(); ++k) {
      pairs["stamp_delay_sigma_ns " + image_topic(rig_, k)] =
          std::to_string(rig_.cameras[k].stamp_delay_sigma.count());
    }
    if (setup_.gnss_lidar) pairs["gnss_lidar"] = rig_.lidars[*setup_.gnss_lidar].name;
    file_.write_metadata(pairs);
  }

 private:
  void write_transforms(Stamp stamp) {
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
      message.transforms.push_back({header_of(stamp, lidar_frame(rig_, index)),
                                    camera_frame(rig_, k),
                                    ros::to_transform(camera.T_camera_lidar.inverse())});
    }
    if (!message.transforms.empty()) file_.write("/tf_static", stamp, message, true);
  }

  void write_datagram(const recording::DatagramEvent& event) {
    const auto& [lidar, datagram] = event;
    const bool position = datagram.payload.size() == velodyne::kPositionPacketSize;
    if (lidar == recording::kNoLidar ||
        (!position && datagram.payload.size() != velodyne::kPacketSize)) {
      ++other_datagrams_;
      return;
    }
    if (!intakes_.empty()) {
      intakes_[lidar]->add_datagram(
          datagram, [&](Sweep& sweep) { deskewed_[lidar]->add_sweep(sweep); },
          [](const GnssFix&) {});
    }
    if (position) {
      ros::UInt8MultiArray bytes{
          {{"bytes", velodyne::kPositionPacketSize, velodyne::kPositionPacketSize}},
          0,
          datagram.payload};
      file_.write(lidar_topic(rig_, lidar) + "/position_packets", datagram.stamp, bytes);
      const auto packet = velodyne::parse_position_packet(datagram.payload);
      if (setup_.gnss_lidar == lidar && packet && packet->sentence)
        write_fix(gnss::stamped_fix(*packet->sentence, datagram.stamp));
      return;
    }
    if (scans_[lidar].is_due(datagram.payload, datagram.stamp)) write_scan(lidar);
    scans_[lidar].add(datagram.payload, datagram.stamp);
  }

  void write_scan(size_t lidar) {
    const Stamp end = scans_[lidar].end();
    file_.write(lidar_topic(rig_, lidar) + "/packets", end,
                scans_[lidar].finish(lidar_frame(rig_, lidar)));
  }

  void write_sweep(const Sweep& sweep, size_t lidar, Stamp log_time) {
    const auto topic = lidar_topic(rig_, lidar) + (sweep.deskewed ? "/points" : "/points_raw");
    file_.write(topic, log_time, ros::to_cloud(sweep, lidar_frame(rig_, lidar), data_));
    if (!intakes_.empty() && !sweep.deskewed) {
      intakes_[lidar]->add_sweep(sweep, [&](Sweep& s) { deskewed_[lidar]->add_sweep(s); });
    }
  }

  std::function<void(const Sweep&, const motion::DeskewedSweep&)> deskewed_writer(size_t lidar) {
    return [this, lidar](const Sweep& sweep, const motion::DeskewedSweep& deskewed) {
      if (!deskewed.usable()) {
        ++not_deskewed_;
        return;
      }
      Sweep moved = sweep;
      moved.stamp = deskewed.reference;
      moved.has_times = false;
      moved.x = deskewed.x;
      moved.y = deskewed.y;
      moved.z = deskewed.z;
      file_.write(lidar_topic(rig_, lidar) + "/points", deskewed.reference,
                  ros::to_cloud(moved, lidar_frame(rig_, lidar), data_));
    };
  }

  void write_image(const recording::ImageEvent& event, Stamp stamp) {
    const auto file = text::read_text(*event.path, kMaxImageBytes);
    if (!file || event.camera >= rig_.cameras.size()) {
      ++unreadable_images_;
      return;
    }
    const auto header = header_of(stamp, camera_frame(rig_, event.camera));
    ros::CompressedImage image{.header = header};
    image.format = format_of(event);
    image.data = {reinterpret_cast<const uint8_t*>(file->data()), file->size()};
    file_.write(image_topic(rig_, event.camera), stamp, image);
    file_.write(camera_topic(rig_, event.camera) + "/camera_info", stamp,
                info_of(rig_.cameras[event.camera].intrinsics, header));
  }

  /// As image_transport writes it: what was compressed, if that is not the usual.
  std::string format_of(const recording::ImageEvent& event) const {
    const std::string file = event.path->extension() == ".png" ? "png" : "jpeg";
    const auto& bayer = setup_.cameras[event.camera].bayer;
    if (!bayer) return file;
    const char* name = *bayer == PixelFormat::kBayerRggb8   ? "bayer_rggb8"
                       : *bayer == PixelFormat::kBayerBggr8 ? "bayer_bggr8"
                       : *bayer == PixelFormat::kBayerGbrg8 ? "bayer_gbrg8"
                                                            : "bayer_grbg8";
    return std::string(name) + "; " + file + " compressed " + name;
  }

  static ros::CameraInfo info_of(const CameraIntrinsics& c, const ros::Header& header) {
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

  /// `source`: "/bus" for what the vehicle's bus says, empty for sensors of their own.
  void write_sample(const VehicleSample& sample, const std::string& source) {
    for (const auto& sweeps : deskewed_) sweeps->add_sample(sample);
    if (const auto* wheels = std::get_if<WheelOdometry>(&sample)) write_wheels(*wheels, source);
    if (const auto* imu = std::get_if<ImuSample>(&sample)) write_imu(*imu, source);
    if (const auto* fix = std::get_if<GnssFix>(&sample)) write_fix(*fix);
  }

  void write_wheels(const WheelOdometry& sample, const std::string& source) {
    ros::TwistStamped message{header_of(sample.stamp, kVehicleFrame), {}};
    const double rear = (sample.wheel_speed[2] + sample.wheel_speed[3]) / 2;
    const bool by_wheels = !std::isfinite(sample.speed);
    message.twist.linear.x = by_wheels ? rear : sample.speed;
    message.twist.angular.z = sample.yaw_rate;
    if (by_wheels && std::isfinite(rear)) ++wheel_samples_;
    if (!std::isfinite(message.twist.linear.x) && !std::isfinite(sample.yaw_rate)) return;
    file_.write("/vehicle" + source + "/twist", sample.stamp, message);
  }

  void write_imu(const ImuSample& sample, const std::string& source) {
    ros::Imu message{.header = header_of(sample.stamp, kVehicleFrame)};
    message.orientation_covariance[0] = -1;  // not measured
    const auto& w = sample.angular_velocity;
    const auto& a = sample.linear_acceleration;
    message.angular_velocity = {w[0], w[1], w[2]};
    message.linear_acceleration = {a[0], a[1], a[2]};
    file_.write("/vehicle" + source + "/imu", sample.stamp, message);
  }

  void write_fix(const GnssFix& fix) {
    constexpr double kDegrees = 180 / std::numbers::pi;
    ros::NavSatFix message{.header = header_of(fix.stamp, "gnss")};
    message.status = static_cast<int8_t>(fix.valid ? 0 : -1);
    message.service = 1;
    message.latitude = fix.latitude * kDegrees;
    message.longitude = fix.longitude * kDegrees;
    message.altitude = fix.altitude;
    file_.write("/gnss/fix", fix.stamp, message);
    write_velocity(fix);
  }

  /// As ROS drivers of GNSS receivers publish it: to the east and north, beside the fix.
  void write_velocity(const GnssFix& fix) {
    const bool stationary = fix.speed == 0;
    if (!std::isfinite(fix.speed)) return;
    if (!stationary && !std::isfinite(fix.course)) {
      ++speeds_without_course_;
      return;
    }
    ros::TwistStamped message{header_of(fix.stamp, "gnss"), {}};
    message.twist.linear.x = stationary ? 0 : fix.speed * std::sin(fix.course);
    message.twist.linear.y = stationary ? 0 : fix.speed * std::cos(fix.course);
    file_.write("/gnss/vel", fix.stamp, message);
  }

  const DriveSetup& setup_;
  const Rig& rig_;
  RosFile& file_;
  VehicleIntake vehicle_;
  std::vector<ScanBuilder> scans_;
  std::vector<std::unique_ptr<LidarIntake>> intakes_;  ///< empty: nothing is deskewed
  std::vector<std::unique_ptr<DeskewedSweeps>> deskewed_;
  std::vector<uint8_t> data_;
  bool started_ = false;
  size_t other_datagrams_ = 0, unreadable_images_ = 0, not_deskewed_ = 0, wheel_samples_ = 0;
  size_t speeds_without_course_ = 0;
};

}  // namespace

Result<McapExportSummary> export_mcap(const std::filesystem::path& drive,
                                      const std::filesystem::path& output,
                                      const McapExportOptions& options) {
  auto setup = open_drive(drive, {}, {});
  if (!setup) return tl::unexpected(setup.error());
  auto file = RosFile::create(output);
  if (!file) return tl::unexpected(file.error());
  McapExportSummary summary;
  DriveExport writer(*setup, *file, options.deskew);
  writer.write_metadata();
  recording::DriveEvent event;
  while (!file->failed() && setup->source.next(event)) writer.write(event);
  writer.finish(summary.notes);
  if (!options.reports.empty()) {
    if (auto done = write_report_messages(options.reports, *file, summary.notes); !done)
      return tl::unexpected(done.error());
  }
  for (const Error& note : setup->source.notes()) summary.notes.push_back(note);
  if (auto closed = file->close(); !closed) return tl::unexpected(closed.error());
  summary.messages = file->messages();
  return summary;
}

Result<McapExportSummary> recover_mcap(const std::filesystem::path& damaged,
                                       const std::filesystem::path& output) {
  std::error_code ignored;
  if (std::filesystem::equivalent(damaged, output, ignored))
    return fail("is the file to recover", output.string(), "choose another name");
  const auto file = recording::MappedFile::open(damaged);
  if (!file) return tl::unexpected(file.error());
  const std::span bytes(reinterpret_cast<const uint8_t*>(file->bytes().data()),
                        file->bytes().size());
  auto reader = mcap::McapReader::open(bytes, damaged.string());
  if (!reader) return tl::unexpected(reader.error());
  auto writer = mcap::McapWriter::create(output);
  if (!writer) return tl::unexpected(writer.error());
  McapExportSummary summary;
  std::map<uint16_t, uint16_t> channels;
  mcap::Message message;
  while (reader->next(message)) {
    if (!channels.contains(message.channel_id)) {
      const auto added = writer->add_channel(*message.channel);
      if (!added) return tl::unexpected(added.error());
      channels[message.channel_id] = *added;
    }
    ++summary.messages[message.channel->topic];
    if (auto done = writer->write(channels[message.channel_id], message.log_time,
                                  message.publish_time, message.data);
        !done)
      return tl::unexpected(done.error());
  }
  for (const auto& [name, pairs] : reader->metadata()) {
    if (auto done = writer->write_metadata(name, pairs); !done) return tl::unexpected(done.error());
  }
  if (auto closed = writer->close(); !closed) return tl::unexpected(closed.error());
  reader->append_notes(summary.notes);
  return summary;
}

}  // namespace infuse::daemon
