#include "drivers/recording/drive_source.hpp"

#include <algorithm>

#include "drivers/recording/event_streams.hpp"

namespace infuse::recording {
namespace {

using Stream = Result<std::unique_ptr<EventStream>>;

// Returns the lidars that share the capture of lidar `first`; empty if an earlier lidar does.
std::vector<LidarRoute> find_routes(const DriveDescription& description, size_t first) {
  const std::string& packets = description.lidars[first].packets;
  std::vector<LidarRoute> routes;
  for (size_t i = 0; i < description.lidars.size(); ++i) {
    const LidarFiles& files = description.lidars[i];
    if (files.packets != packets) continue;
    if (i < first) return {};
    routes.push_back({i, files.port, files.position_port, files.sender});
  }
  return routes;
}

// Opens all streams of a drive, in the order that applies to events with equal stamps.
std::vector<Stream> open_streams(const Drive& drive) {
  const DriveDescription& description = drive.description;
  std::vector<Stream> streams;
  for (size_t i = 0; i < description.lidars.size(); ++i) {
    const LidarFiles& files = description.lidars[i];
    if (!files.sweeps.empty()) {
      streams.push_back(
          open_sweep_stream(drive.resolve(files.sweeps), i, files, description.times_trusted));
    } else if (auto routes = find_routes(description, i); !routes.empty()) {
      streams.push_back(open_capture_stream(drive.resolve(files.packets), {}, std::move(routes)));
    }
  }
  for (size_t i = 0; i < description.cameras.size(); ++i) {
    streams.push_back(open_image_stream(drive.resolve(description.cameras[i].images), i,
                                        description.rig.cameras[i].stamp_delay));
  }
  if (description.can) streams.push_back(open_can_stream(drive.resolve(description.can->log)));
  if (!description.speed.empty())
    streams.push_back(open_speed_stream(drive.resolve(description.speed)));
  if (!description.imu.empty())
    streams.push_back(open_imu_stream(drive.resolve(description.imu), description.imu_delay));
  if (!description.gnss.empty())
    streams.push_back(open_gnss_stream(drive.resolve(description.gnss)));
  return streams;
}

}  // namespace

Result<DriveSource> DriveSource::open(const Drive& drive) {
  DriveSource source;
  for (Stream& stream : open_streams(drive)) {
    if (!stream) return tl::unexpected(std::move(stream.error()));
    source.add(std::move(*stream));
  }
  return source;
}

Result<DriveSource> DriveSource::open_capture(const std::filesystem::path& path,
                                              const PcapOptions& options) {
  Stream stream = open_capture_stream(path, options, {});
  if (!stream) return tl::unexpected(std::move(stream.error()));
  DriveSource source;
  source.add(std::move(*stream));
  return source;
}

void DriveSource::add(std::unique_ptr<EventStream> stream) {
  inputs_.push_back({std::move(stream), {}, false});
}

bool DriveSource::next(DriveEvent& event) {
  if (!started_) {
    started_ = true;
    for (Input& input : inputs_) advance(input);
  } else if (current_input_ != kNoInput) {
    advance(inputs_[current_input_]);
  }
  current_input_ = kNoInput;
  for (size_t i = 0; i < inputs_.size(); ++i) {
    if (!inputs_[i].has_pending) continue;
    if (current_input_ == kNoInput ||
        inputs_[i].pending.stamp < inputs_[current_input_].pending.stamp)
      current_input_ = i;
  }
  if (current_input_ == kNoInput) return false;
  event = inputs_[current_input_].pending;
  if (event.stamp < last_stamp_) ++out_of_order_count_;
  last_stamp_ = event.stamp;
  return true;
}

std::vector<Error> DriveSource::notes() const {
  std::vector<Error> notes;
  for (const Input& input : inputs_) input.stream->append_notes(notes);
  return notes;
}

}  // namespace infuse::recording
