#include "daemon/tools/export/mcap_export.hpp"

#include <functional>
#include <memory>

#include "daemon/pipeline/lidar_intake.hpp"
#include "daemon/pipeline/odometry_plan.hpp"
#include "daemon/pipeline/vehicle_intake.hpp"
#include "daemon/playback/deskewed_sweeps.hpp"
#include "daemon/playback/read_image.hpp"
#include "daemon/ros/report_messages.hpp"
#include "daemon/ros/ros_file.hpp"
#include "daemon/ros/sensor_messages.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "drivers/mcap/mcap_reader.hpp"
#include "drivers/recording/mapped_file.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

/// Writes the events of a drive.
class DriveExport {
 public:
  DriveExport(const SensorSetup& setup, RosFile& file, bool deskew)
      : setup_(setup), messages_(message_setup(setup), file), vehicle_(setup.vehicle) {
    const MessageSetup messages = message_setup(setup);
    for (size_t k = 0; k < setup.rig.lidars.size(); ++k) {
      const bool packets_only = replaces_clouds(messages.packet_makers[k]);
      writes_raw_.push_back(setup.lidars[k].has_packets && !packets_only);
      const bool decodes = deskew || writes_raw_[k];
      intakes_.push_back(decodes ? std::make_unique<LidarIntake>(setup.lidars[k]) : nullptr);
      if (!deskew) continue;
      deskewed_.push_back(std::make_unique<DeskewedSweeps>(plan_odometry({}, setup, k),
                                                           setup.rig.lidars[k].T_vehicle_lidar));
    }
  }

  void write(const recording::DriveEvent& event) {
    if (!started_) messages_.write_constants(event.stamp);
    started_ = true;
    if (const auto* datagram = std::get_if<recording::DatagramEvent>(&event.content)) {
      write_datagram(*datagram);
    } else if (const auto* sweep = std::get_if<recording::SweepEvent>(&event.content)) {
      write_sweep(*sweep->sweep, sweep->lidar, event.stamp);
    } else if (const auto* image = std::get_if<recording::ImageEvent>(&event.content)) {
      write_image(*image, event.stamp);
    } else if (const auto* bus = std::get_if<recording::CanLineEvent>(&event.content)) {
      vehicle_.add_can_line(bus->line, event.stamp,
                            [&](const VehicleSample& sample) { write_sample(sample, true); });
    } else if (const auto* speed = std::get_if<WheelOdometry>(&event.content)) {
      write_sample(*speed, false);
    } else if (const auto* imu = std::get_if<ImuSample>(&event.content)) {
      write_sample(*imu, false);
    } else if (const auto* fix = std::get_if<GnssFix>(&event.content)) {
      write_sample(*fix, false);
    }
    for (size_t k = 0; k < deskewed_.size(); ++k)
      deskewed_[k]->process_due(event.stamp, deskewed_writer(k));
  }

  void finish(std::vector<Error>& notes) {
    messages_.finish();
    for (size_t k = 0; k < intakes_.size(); ++k) {
      if (intakes_[k] != nullptr) intakes_[k]->finish([&](Sweep& sweep) { add_decoded(k, sweep); });
    }
    for (size_t k = 0; k < deskewed_.size(); ++k) deskewed_[k]->finish(deskewed_writer(k));
    messages_.append_notes(notes);
    const auto note = [&](size_t count, const char* what) {
      if (count > 0) notes.push_back({std::to_string(count) + " " + what, "", ""});
    };
    note(unreadable_images_, "images are not written: they cannot be read");
    note(not_deskewed_, "sweeps are not on .../points: odometry does not cover them");
  }

  std::map<std::string, std::string> metadata() const { return messages_.metadata(); }

 private:
  void write_datagram(const recording::DatagramEvent& event) {
    const size_t lidar = event.lidar;
    const Datagram& datagram = event.datagram;
    if (lidar == recording::kNoLidar) return messages_.count_other_datagram();
    messages_.add_datagram(lidar, datagram.payload, datagram.stamp);
    const lidar::LidarMaker& maker = *setup_.lidars[lidar].decoder.model->maker;
    const lidar::PacketClass packet_class = maker.classify(datagram.payload);
    if (packet_class == lidar::PacketClass::kOther) return;
    if (intakes_[lidar] != nullptr) {
      intakes_[lidar]->add_datagram(datagram, [&](Sweep& sweep) { add_decoded(lidar, sweep); });
    }
    if (packet_class != lidar::PacketClass::kInformation || setup_.gnss_lidar != lidar) return;
    if (const auto fix = maker.read_fix(datagram)) messages_.write_fix(*fix);
  }

  void add_decoded(size_t lidar, const Sweep& sweep) {
    if (writes_raw_[lidar]) messages_.write_sweep(lidar, sweep, sweep.stamp + sweep.span);
    if (!deskewed_.empty()) deskewed_[lidar]->add_sweep(sweep);
  }

  void write_sweep(const Sweep& sweep, size_t lidar, Stamp log_time) {
    messages_.write_sweep(lidar, sweep, log_time);
    if (!deskewed_.empty() && !sweep.deskewed) {
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
      moved.x = deskewed.x;
      moved.y = deskewed.y;
      moved.z = deskewed.z;
      messages_.write_deskewed(lidar, moved, deskewed.reference);
    };
  }

  void write_image(const recording::ImageEvent& event, Stamp stamp) {
    const auto file = text::read_text(*event.path, kMaxImageBytes);
    if (!file || event.camera >= setup_.rig.cameras.size()) {
      ++unreadable_images_;
      return;
    }
    messages_.write_image(event.camera,
                          {{reinterpret_cast<const uint8_t*>(file->data()), file->size()},
                           event.path->extension() == ".png",
                           setup_.cameras[event.camera].image.bayer},
                          stamp);
  }

  void write_sample(const VehicleSample& sample, bool from_bus) {
    for (const auto& sweeps : deskewed_) sweeps->add_sample(sample);
    messages_.write_sample(sample, from_bus);
  }

  const SensorSetup& setup_;
  SensorMessages messages_;
  VehicleIntake vehicle_;
  std::vector<bool> writes_raw_;  ///< by lidar: there is no message for its packets
  std::vector<std::unique_ptr<LidarIntake>> intakes_;      ///< by lidar; null: it is not decoded
  std::vector<std::unique_ptr<DeskewedSweeps>> deskewed_;  ///< empty: nothing is deskewed
  bool started_ = false;
  size_t unreadable_images_ = 0, not_deskewed_ = 0;
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
  file->write_metadata(writer.metadata());
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
