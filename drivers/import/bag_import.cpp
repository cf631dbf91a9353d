#include "drivers/import/bag_import.hpp"

#include <map>

#include "drivers/import/bag.hpp"
#include "drivers/import/bag_mounts.hpp"
#include "drivers/import/bag_packets.hpp"
#include "drivers/import/bag_samples.hpp"
#include "drivers/import/bag_sinks.hpp"
#include "drivers/import/import_files.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/text/numbers.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::importers {
namespace {

namespace fs = std::filesystem;

/// Writes the messages of the selected topics.
class BagImport {
 public:
  BagImport(const fs::path& drive, const BagImportOptions& options, BagImportSummary& summary)
      : drive_(drive), options_(options), summary_(summary), samples_(summary) {}

  Result<void> prepare() {
    for (const BagLidar& lidar : summary_.selection.lidars) {
      if (auto made = add_lidar(lidar); !made) return made;
    }
    for (const BagCamera& camera : summary_.selection.cameras) {
      if (auto made = add_camera(camera); !made) return made;
    }
    samples_.set_imu_rotation(
        rotation_of(summary_.selection.imu, "the samples", options_.vehicle_frame, summary_));
    return {};
  }

  Result<void> add(const BagMessage& message) {
    const std::string topic(message.topic);
    if (const auto packets = packets_.find(topic); packets != packets_.end()) {
      return add_packets(message, packets->second, &PacketSink::add);
    }
    if (const auto lidar = metadata_.find(topic); lidar != metadata_.end()) {
      return add_metadata(message, lidar->second);
    }
    if (const auto lidar = positions_.find(topic); lidar != positions_.end()) {
      PacketSink& sink = packets_.at(lidar->second);
      if (holds_packets(message.type)) {
        return add_packets(message, sink, &PacketSink::add_position);
      }
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
    samples_.add(message, topic);
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
    if (samples_.unreadable() > 0) {
      summary_.notes.push_back({std::to_string(samples_.unreadable()) +
                                    " messages of speed, inertial unit or GNSS are skipped",
                                "", "they are truncated or not finite"});
    }
    complete_lidars();
    complete_cameras();
    if (auto done = samples_.write(drive_, description_); !done) return done;
    description_.name = "ROS recording";
    return recording::write_drive_toml(drive_, description_);
  }

 private:
  template <class T, class Sink, class OnMessage>
  static Result<void> add_to(const BagMessage& message, Sink& sink, OnMessage on_message) {
    const auto read = ros::decode<T>(message.data, message.encoding);
    if (read) return on_message(*read);
    sink.skipped.add("is not of the topic's type, or truncated");
    return {};
  }

  using AddPacket = Result<void> (PacketSink::*)(std::span<const uint8_t>, Stamp);
  static Result<void> add_packets(const BagMessage& message, PacketSink& sink, AddPacket add) {
    Result<void> done;
    const auto add_one = [&](Stamp stamp, std::span<const uint8_t> payload) {
      if (done) done = (sink.*add)(payload, stamp);
    };
    if (!read_packets(message, add_one))
      sink.skipped.add("is not of the topic's type, or truncated");
    return done;
  }

  /// Writes a unit's metadata beside its capture, once.
  Result<void> add_metadata(const BagMessage& message, const BagLidar* lidar) {
    PacketSink& sink = packets_.at(lidar->topic);
    const auto read = ros::decode<ros::String>(message.data, message.encoding);
    if (!read || !sink.calibration().empty()) return {};
    sink.set_calibration(lidar->name + ".json");
    return text::write_text(drive_ / sink.calibration(), read->data);
  }

  Result<void> add_lidar(const BagLidar& lidar) {
    description_.rig.lidars.push_back(mount_of(lidar, options_.vehicle_frame, summary_));
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
    if (!lidar.metadata.empty()) metadata_.emplace(lidar.metadata, &lidar);
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
    relate_to_lidar(camera, mount, summary_);
    const auto sigma = text::parse_integer(metadata("stamp_delay_sigma_ns " + camera.topic));
    mount.stamp_delay_sigma = Duration(sigma.value_or(0));
    mount.readout =
        Duration(text::parse_integer(metadata("readout_ns " + camera.topic)).value_or(0));
    description_.rig.cameras.push_back(mount);
    auto& files = description_.cameras.emplace_back();
    files.images = "images_" + camera.name;
    auto sink = ImageSink::create(drive_ / files.images, *intrinsics);
    if (!sink) return tl::unexpected(sink.error());
    images_.emplace(camera.topic, std::move(*sink));
    return {};
  }

  /// What a file of infuse states beside the messages; empty otherwise.
  std::string metadata(const std::string& key) const {
    const auto of_infuse = summary_.survey.metadata.find("infuse");
    if (of_infuse == summary_.survey.metadata.end()) return "";
    const auto found = of_infuse->second.find(key);
    return found == of_infuse->second.end() ? "" : found->second;
  }

  void complete_lidars() {
    for (size_t k = 0; k < summary_.selection.lidars.size(); ++k) {
      const BagLidar& lidar = summary_.selection.lidars[k];
      const auto sink = packets_.find(lidar.topic);
      if (sink == packets_.end()) continue;
      description_.lidars[k].calibration = sink->second.calibration();
      if (const auto model = sink->second.model()) description_.rig.lidars[k].model = model->name;
      const bool carries_fixes = !samples_.has_fixes() || metadata("gnss_lidar") == lidar.name;
      if (sink->second.has_positions() && carries_fixes && description_.gnss_lidar.empty())
        description_.gnss_lidar = lidar.name;
    }
    if (!description_.gnss_lidar.empty() && samples_.has_fixes()) {
      summary_.selection.reasons[summary_.selection.gnss] =
          "the lidar's position packets carry the fixes";
      summary_.selection.gnss.clear();
      if (!summary_.selection.velocity.empty())
        summary_.selection.reasons[summary_.selection.velocity] =
            "the lidar's position packets carry the fixes";
      summary_.selection.velocity.clear();
      samples_.drop_fixes();
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

  const fs::path& drive_;
  const BagImportOptions& options_;
  BagImportSummary& summary_;
  recording::DriveDescription description_;
  std::map<std::string, PacketSink> packets_;        ///< by topic
  std::map<std::string, std::string> positions_;     ///< topic of the data packets
  std::map<std::string, const BagLidar*> metadata_;  ///< by topic
  std::map<std::string, CloudSink> clouds_;
  std::map<std::string, ImageSink> images_;
  BagSamples samples_;
};

}  // namespace

std::string BagImportSummary::use_of(const std::string& topic) const {
  const BagTopic* found = survey.find(topic);
  if (found == nullptr || selection.reasons.contains(topic)) return "";
  for (const BagLidar& lidar : selection.lidars) {
    if (topic == lidar.topic) return "lidar " + lidar.name;
    if (topic == lidar.positions) return "positions of the lidar " + lidar.name;
    if (topic == lidar.metadata) return "metadata of the lidar " + lidar.name;
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
