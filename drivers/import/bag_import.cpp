#include "drivers/import/bag_import.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/gnss/gnss_csv.hpp"
#include "drivers/import/bag.hpp"
#include "drivers/import/bag_sinks.hpp"
#include "drivers/import/import_files.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/imu_csv.hpp"
#include "drivers/recording/speed_csv.hpp"
#include "drivers/text/numbers.hpp"

namespace infuse::importers {
namespace {

namespace fs = std::filesystem;

constexpr double kBagNan = std::numeric_limits<double>::quiet_NaN();

Stamp stamp_of(const ros::Header& header, Stamp log_time) {
  const Stamp stamp = header.stamp.stamp();
  return stamp == Stamp() ? log_time : stamp;
}

std::array<double, 3> rotate(const Eigen::Matrix3d& rotation, const ros::Vector3& v) {
  const Eigen::Vector3d rotated = rotation * Eigen::Vector3d(v.x, v.y, v.z);
  return {rotated.x(), rotated.y(), rotated.z()};
}

bool is_finite(const std::array<double, 3>& v) { return std::isfinite(v[0] + v[1] + v[2]); }

/// Intrinsics of a camera_info. Errors: a distortion that infuse does not have.
Result<CameraIntrinsics> intrinsics_of(const BagCamera& camera) {
  const ros::CameraInfo& info = camera.info;
  CameraIntrinsics intrinsics;
  intrinsics.width = static_cast<int>(std::min<uint32_t>(info.width, 1 << 20));
  intrinsics.height = static_cast<int>(std::min<uint32_t>(info.height, 1 << 20));
  intrinsics.fx = camera.rectified ? info.p[0] : info.k[0];
  intrinsics.fy = camera.rectified ? info.p[5] : info.k[4];
  intrinsics.cx = camera.rectified ? info.p[2] : info.k[2];
  intrinsics.cy = camera.rectified ? info.p[6] : info.k[5];
  if (info.binning_x > 1 || info.binning_y > 1 || info.roi.x_offset != 0 || info.roi.y_offset != 0)
    return fail("has a camera_info with binning or a region of interest, which is not taken");
  const bool fisheye = info.distortion_model == "equidistant" || info.distortion_model == "fisheye";
  if (camera.rectified) return intrinsics;
  if (fisheye) intrinsics.model = CameraIntrinsics::Model::kFisheye;
  const size_t terms = fisheye ? 4 : intrinsics.distortion.size();
  for (size_t k = 0; k < info.d.size(); ++k) {
    if (k < terms) {
      intrinsics.distortion[k] = info.d[k];
    } else if (info.d[k] != 0) {
      return fail("has the distortion '" + info.distortion_model + "' of " +
                  std::to_string(info.d.size()) + " terms, which is not taken");
    }
  }
  return intrinsics;
}

/// Writes the messages of the selected topics.
class BagImport {
 public:
  BagImport(const fs::path& drive, const BagImportOptions& options, BagImportSummary& summary)
      : drive_(drive), options_(options), summary_(summary) {}

  Result<void> prepare() {
    for (const BagLidar& lidar : summary_.selection.lidars) {
      if (auto made = add_lidar(lidar); !made) return made;
    }
    for (const BagCamera& camera : summary_.selection.cameras) {
      if (auto made = add_camera(camera); !made) return made;
    }
    R_vehicle_imu_ = rotation_of(summary_.selection.imu, "the samples");
    return {};
  }

  Result<void> add(const BagMessage& message) {
    const std::string topic(message.topic);
    if (const auto packets = packets_.find(topic); packets != packets_.end())
      return add_to<ros::VelodyneScan>(message, packets->second, [&](const auto& scan) {
        return packets->second.add(scan, stamp_of(scan.header, message.log_time));
      });
    if (const auto lidar = positions_.find(topic); lidar != positions_.end()) {
      PacketSink& sink = packets_.at(lidar->second);
      return add_to<ros::UInt8MultiArray>(message, sink, [&](const auto& bytes) {
        return sink.add_position(bytes.data, message.log_time);
      });
    }
    if (const auto clouds = clouds_.find(topic); clouds != clouds_.end())
      return add_to<ros::PointCloud2>(message, clouds->second, [&](const auto& cloud) {
        return clouds->second.add(cloud, stamp_of(cloud.header, message.log_time));
      });
    if (const auto images = images_.find(topic); images != images_.end()) {
      ImageSink& sink = images->second;
      if (message.type == ros::CompressedImage::kName)
        return add_to<ros::CompressedImage>(message, sink, [&](const auto& image) {
          return sink.add(image, stamp_of(image.header, message.log_time));
        });
      return add_to<ros::Image>(message, sink, [&](const auto& image) {
        return sink.add(image, stamp_of(image.header, message.log_time));
      });
    }
    add_sample(message, topic);
    return {};
  }

  Result<void> finish() {
    for (auto& [topic, sink] : packets_) {
      if (auto done = sink.finish(); !done) return done;
      summary_.packets += sink.packets();
      sink.skipped.append_notes(topic, summary_.notes);
    }
    for (auto& [topic, sink] : clouds_) {
      if (auto done = sink.finish(); !done) return done;
      summary_.sweeps += sink.sweeps();
      sink.skipped.append_notes(topic, summary_.notes);
      if (sink.without_times() > 0) {
        summary_.notes.push_back(
            {std::to_string(sink.without_times()) + " clouds have no time of each point", topic,
             "they are used as measured, not deskewed"});
      }
    }
    for (auto& [topic, sink] : images_) {
      if (auto done = sink.finish(); !done) return done;
      summary_.images += sink.images();
      sink.skipped.append_notes(topic, summary_.notes);
    }
    if (unreadable_samples_ > 0) {
      summary_.notes.push_back({std::to_string(unreadable_samples_) +
                                    " messages of speed, inertial unit or GNSS are skipped",
                                "", "they are cut or not finite"});
    }
    complete_lidars();
    complete_cameras();
    if (auto done = write_samples(); !done) return done;
    description_.name = "ROS recording";
    return recording::write_drive_toml(drive_, description_);
  }

 private:
  /// Velocity over ground, m/s.
  struct Velocity {
    Stamp stamp;
    double east, north;
  };

  template <class T, class Sink, class OnMessage>
  static Result<void> add_to(const BagMessage& message, Sink& sink, OnMessage on_message) {
    const auto read = ros::decode<T>(message.data, message.encoding);
    if (read) return on_message(*read);
    sink.skipped.add("is not of the topic's type, or cut");
    return {};
  }

  Result<void> add_lidar(const BagLidar& lidar) {
    LidarMount mount;
    mount.name = lidar.name;
    if (const auto T = summary_.survey.frames.find(options_.vehicle_frame, lidar.frame)) {
      mount.T_vehicle_lidar = *T;
    } else {
      summary_.notes.push_back({"no transform between '" + options_.vehicle_frame + "' and '" +
                                    lidar.frame + "': the mounting is unknown",
                                lidar.topic, "set T_vehicle_lidar in drive.toml"});
    }
    description_.rig.lidars.push_back(mount);
    auto& files = description_.lidars.emplace_back();
    if (!lidar.has_packets) {
      files.sweeps = "sweeps_" + lidar.name;
      auto sink = CloudSink::create(drive_ / files.sweeps);
      if (!sink) return tl::unexpected(sink.error());
      clouds_.emplace(lidar.topic, std::move(*sink));
      return {};
    }
    files.packets = lidar.name + ".pcap";
    auto sink = PacketSink::create(drive_ / files.packets);
    if (!sink) return tl::unexpected(sink.error());
    packets_.emplace(lidar.topic, std::move(*sink));
    if (!lidar.positions.empty()) positions_.emplace(lidar.positions, lidar.topic);
    return {};
  }

  Result<void> add_camera(const BagCamera& camera) {
    const auto skip = [&](const std::string& reason) {
      summary_.selection.reasons[camera.topic] = reason;
      return Result<void>{};
    };
    const auto intrinsics = intrinsics_of(camera);
    if (!intrinsics) return skip(intrinsics.error().what);
    if (const auto wrong = intrinsics->invalid())
      return skip("its camera_info is wrong: " + *wrong);
    if (description_.rig.lidars.empty()) return skip("there is no lidar to relate it to");
    CameraMount mount;
    mount.name = camera.name;
    mount.intrinsics = *intrinsics;
    relate_to_lidar(camera, mount);
    const auto sigma = text::parse_integer(metadata("stamp_delay_sigma_ns " + camera.topic));
    mount.stamp_delay_sigma = Duration(sigma.value_or(0));
    description_.rig.cameras.push_back(mount);
    auto& files = description_.cameras.emplace_back();
    files.images = "images_" + camera.name;
    auto sink = ImageSink::create(drive_ / files.images, *intrinsics);
    if (!sink) return tl::unexpected(sink.error());
    images_.emplace(camera.topic, std::move(*sink));
    return {};
  }

  /// The lidar that the camera's frame is attached to, else the first that is connected with it.
  void relate_to_lidar(const BagCamera& camera, CameraMount& mount) {
    const FrameTree& frames = summary_.survey.frames;
    const auto& lidars = summary_.selection.lidars;
    const auto direct = std::ranges::find(lidars, frames.parent_of(camera.frame), &BagLidar::frame);
    if (direct != lidars.end()) {
      if (const auto T = frames.find(camera.frame, direct->frame)) {
        mount.lidar = direct->name;
        mount.T_camera_lidar = *T;
        return;
      }
    }
    for (const BagLidar& lidar : lidars) {
      const auto T = frames.find(camera.frame, lidar.frame);
      if (!T) continue;
      mount.lidar = lidar.name;
      mount.T_camera_lidar = *T;
      return;
    }
    mount.lidar = lidars.front().name;
    mount.T_camera_lidar.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
    summary_.notes.push_back({"no transform between '" + camera.frame +
                                  "' and a lidar: the pose of " +
                                  "the camera is not known, it is set to look along the lidar's x",
                              camera.topic, "set T_camera_lidar in drive.toml"});
  }

  /// What a file of infuse states beside the messages; empty otherwise.
  std::string metadata(const std::string& key) const {
    const auto of_infuse = summary_.survey.metadata.find("infuse");
    if (of_infuse == summary_.survey.metadata.end()) return "";
    const auto found = of_infuse->second.find(key);
    return found == of_infuse->second.end() ? "" : found->second;
  }

  /// Rotation from the frame of a topic's messages to the vehicle's.
  Eigen::Matrix3d rotation_of(const std::string& name, const char* what) {
    const BagTopic* topic = name.empty() ? nullptr : summary_.survey.find(name);
    if (topic == nullptr || topic->frame.empty()) return Eigen::Matrix3d::Identity();
    if (const auto T = summary_.survey.frames.find(options_.vehicle_frame, topic->frame))
      return T->linear();
    summary_.notes.push_back({"no transform between '" + options_.vehicle_frame + "' and '" +
                                  topic->frame + "': " + what + " are taken as along the " +
                                  "vehicle's axes",
                              name, ""});
    return Eigen::Matrix3d::Identity();
  }

  void add_sample(const BagMessage& message, const std::string& topic) {
    bool sound = true;
    if (topic == summary_.selection.speed) {
      sound = add_speed(message);
    } else if (topic == summary_.selection.imu) {
      sound = add_imu(message);
    } else if (topic == summary_.selection.gnss) {
      sound = add_fix(message);
    } else if (topic == summary_.selection.velocity) {
      sound = add_velocity(message);
    }
    if (!sound) ++unreadable_samples_;
  }

  bool add_twist(const ros::Header& header, const ros::Twist& twist, Stamp log_time) {
    WheelOdometry sample;
    sample.stamp = stamp_of(header, log_time);
    sample.speed = twist.linear.x;
    sample.yaw_rate = twist.angular.z;
    if (!std::isfinite(sample.speed) && !std::isfinite(sample.yaw_rate)) return false;
    speeds_.push_back(sample);
    return true;
  }

  bool add_speed(const BagMessage& message) {
    if (message.type == ros::Odometry::kName) {
      const auto odometry = ros::decode<ros::Odometry>(message.data, message.encoding);
      return odometry && add_twist(odometry->header, odometry->twist, message.log_time);
    }
    const auto twist = ros::decode<ros::TwistStamped>(message.data, message.encoding);
    return twist && add_twist(twist->header, twist->twist, message.log_time);
  }

  bool add_imu(const BagMessage& message) {
    const auto imu = ros::decode<ros::Imu>(message.data, message.encoding);
    if (!imu) return false;
    const ImuSample sample{stamp_of(imu->header, message.log_time),
                           rotate(R_vehicle_imu_, imu->angular_velocity),
                           rotate(R_vehicle_imu_, imu->linear_acceleration)};
    if (!is_finite(sample.angular_velocity) || !is_finite(sample.linear_acceleration)) return false;
    imu_.push_back(sample);
    return true;
  }

  bool add_fix(const BagMessage& message) {
    constexpr double kRadians = std::numbers::pi / 180;
    const auto fix = ros::decode<ros::NavSatFix>(message.data, message.encoding);
    if (!fix || !(std::abs(fix->latitude) <= 90) || !(std::abs(fix->longitude) <= 360))
      return false;
    fixes_.push_back({.stamp = stamp_of(fix->header, message.log_time),
                      .latitude = fix->latitude * kRadians,
                      .longitude = fix->longitude * kRadians,
                      .altitude = fix->altitude,
                      .speed = kBagNan,
                      .course = kBagNan,
                      .hdop = kBagNan,
                      .valid = fix->status >= 0});
    return true;
  }

  bool add_velocity(const BagMessage& message) {
    if (message.type == ros::TwistStamped::kName) {
      const auto twist = ros::decode<ros::TwistStamped>(message.data, message.encoding);
      return twist && add_over_ground(twist->header, twist->twist, message.log_time);
    }
    const auto twist = ros::decode<ros::TwistWithCovarianceStamped>(message.data, message.encoding);
    return twist && add_over_ground(twist->header, twist->twist, message.log_time);
  }

  bool add_over_ground(const ros::Header& header, const ros::Twist& twist, Stamp log_time) {
    const double east = twist.linear.x, north = twist.linear.y;
    if (!std::isfinite(east + north)) return false;
    velocities_.push_back({stamp_of(header, log_time), east, north});
    return true;
  }

  /// Gives each fix the speed and course of the nearest velocity.
  void join_velocities() {
    constexpr Duration kMaxGap{50'000'000};
    std::ranges::stable_sort(velocities_, {}, &Velocity::stamp);
    size_t without = 0;
    for (GnssFix& fix : fixes_) {
      auto nearest = std::ranges::lower_bound(velocities_, fix.stamp, {}, &Velocity::stamp);
      if (nearest != velocities_.begin() &&
          (nearest == velocities_.end() ||
           fix.stamp - std::prev(nearest)->stamp < nearest->stamp - fix.stamp))
        --nearest;
      if (nearest == velocities_.end() || distance_between(nearest->stamp, fix.stamp) > kMaxGap) {
        if (fix.valid) ++without;
        continue;
      }
      const double course = std::atan2(nearest->east, nearest->north);
      fix.speed = std::hypot(nearest->east, nearest->north);
      if (fix.speed > 0) fix.course = course < 0 ? course + 2 * std::numbers::pi : course;
    }
    if (without > 0 && !velocities_.empty()) {
      summary_.notes.push_back({std::to_string(without) + " fixes have no velocity within 50 ms",
                                summary_.selection.velocity, ""});
    }
  }

  void complete_lidars() {
    for (size_t k = 0; k < summary_.selection.lidars.size(); ++k) {
      const BagLidar& lidar = summary_.selection.lidars[k];
      const auto sink = packets_.find(lidar.topic);
      if (sink == packets_.end()) continue;
      if (const auto model = sink->second.model())
        description_.rig.lidars[k].model = velodyne::model_info(*model).name;
      const bool carries_fixes = fixes_.empty() || metadata("gnss_lidar") == lidar.name;
      if (sink->second.has_positions() && carries_fixes && description_.gnss_lidar.empty())
        description_.gnss_lidar = lidar.name;
    }
    if (!description_.gnss_lidar.empty() && !fixes_.empty()) {
      summary_.selection.reasons[summary_.selection.gnss] =
          "the lidar's position packets carry the fixes";
      summary_.selection.gnss.clear();
      if (!summary_.selection.velocity.empty())
        summary_.selection.reasons[summary_.selection.velocity] =
            "the lidar's position packets carry the fixes";
      summary_.selection.velocity.clear();
      fixes_.clear();
    }
  }

  void complete_cameras() {
    for (size_t k = 0; k < description_.cameras.size(); ++k) {
      for (const BagCamera& camera : summary_.selection.cameras) {
        const auto sink = images_.find(camera.topic);
        if (camera.name == description_.rig.cameras[k].name && sink != images_.end())
          description_.cameras[k].mosaic = sink->second.mosaic();
      }
    }
  }

  Result<void> write_samples() {
    const auto by_stamp = [](const auto& a, const auto& b) { return a.stamp < b.stamp; };
    std::stable_sort(speeds_.begin(), speeds_.end(), by_stamp);
    std::stable_sort(imu_.begin(), imu_.end(), by_stamp);
    std::stable_sort(fixes_.begin(), fixes_.end(), by_stamp);
    join_velocities();
    summary_.speeds = speeds_.size();
    summary_.imu_samples = imu_.size();
    summary_.fixes = fixes_.size();
    if (!speeds_.empty()) {
      description_.speed = "speed.csv";
      if (auto done = recording::write_speed_csv(drive_ / "speed.csv", speeds_, true); !done)
        return done;
    }
    if (!imu_.empty()) {
      description_.imu = "imu.csv";
      if (auto done = recording::write_imu_csv(drive_ / "imu.csv", imu_); !done) return done;
    }
    if (!fixes_.empty()) {
      description_.gnss = "gnss.csv";
      if (auto done = gnss::write_gnss_csv(drive_ / "gnss.csv", fixes_); !done) return done;
    }
    return {};
  }

  const fs::path& drive_;
  const BagImportOptions& options_;
  BagImportSummary& summary_;
  recording::DriveDescription description_;
  std::map<std::string, PacketSink> packets_;     ///< by topic
  std::map<std::string, std::string> positions_;  ///< topic of the data packets
  std::map<std::string, CloudSink> clouds_;
  std::map<std::string, ImageSink> images_;
  Eigen::Matrix3d R_vehicle_imu_ = Eigen::Matrix3d::Identity();
  std::vector<WheelOdometry> speeds_;
  std::vector<ImuSample> imu_;
  std::vector<GnssFix> fixes_;
  std::vector<Velocity> velocities_;
  size_t unreadable_samples_ = 0;
};

}  // namespace

std::string BagImportSummary::use_of(const std::string& topic) const {
  const BagTopic* found = survey.find(topic);
  if (found == nullptr || selection.reasons.contains(topic)) return "";
  for (const BagLidar& lidar : selection.lidars) {
    if (topic == lidar.topic) return "lidar " + lidar.name;
    if (topic == lidar.positions) return "positions of the lidar " + lidar.name;
  }
  for (const BagCamera& camera : selection.cameras) {
    if (topic == camera.topic) return "camera " + camera.name;
  }
  if (topic == selection.speed) return "speed";
  if (topic == selection.imu) return "inertial unit";
  if (topic == selection.gnss) return "GNSS";
  if (topic == selection.velocity) return "speed and course of GNSS";
  if (found->type == ros::TfMessage::kName) return "transforms";
  if (found->type == ros::CameraInfo::kName) return "intrinsics";
  return "";
}

Result<BagImportSummary> import_bags(const std::vector<fs::path>& paths, const fs::path& drive,
                                     const BagImportOptions& options) {
  const auto files = list_bags(paths);
  if (!files) return tl::unexpected(files.error());
  auto survey = survey_bags(*files);
  if (!survey) return tl::unexpected(survey.error());
  auto selection = select_topics(*survey, options.topics);
  if (!selection) return tl::unexpected(selection.error());
  BagImportSummary summary;
  summary.survey = std::move(*survey);
  summary.selection = std::move(*selection);
  summary.notes = summary.survey.notes;
  const BagSelection& selected = summary.selection;
  if (selected.lidars.empty() && selected.speed.empty() && selected.imu.empty() &&
      selected.gnss.empty()) {
    std::string names;
    for (const BagTopic& topic : summary.survey.topics)
      names += (names.empty() ? "" : ", ") + topic.name + " (" + topic.type + ")";
    return fail("contains nothing that a drive can hold", files->front().string(),
                "topics: " + (names.empty() ? "none" : names));
  }
  if (auto made = make_empty_folder(drive); !made) return tl::unexpected(made.error());
  BagImport import(drive, options, summary);
  if (auto done = import.prepare(); !done) return tl::unexpected(done.error());
  for (const auto& file : *files) {
    const auto bag = open_bag(file);
    if (!bag) return tl::unexpected(bag.error());
    BagMessage message;
    while ((*bag)->next(message)) {
      if (auto done = import.add(message); !done) return tl::unexpected(done.error());
    }
  }
  if (auto done = import.finish(); !done) return tl::unexpected(done.error());
  return summary;
}

}  // namespace infuse::importers
