#include "daemon/tools/map/map_drive.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <iterator>
#include <numeric>

#include "daemon/command_line/progress_line.hpp"
#include "daemon/mapping/place_map.hpp"
#include "daemon/playback/play_lidar.hpp"
#include "daemon/protocol/json_encoder.hpp"
#include "daemon/tools/map/lidar_replay.hpp"
#include "fusion/features/air_returns.hpp"
#include "fusion/mapping/keyframe_submaps.hpp"
#include "fusion/places/place_descriptor.hpp"

namespace infuse::daemon {
namespace {

/// Bytes of a file, or of all files of a folder.
uint64_t bytes_of(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_regular_file(path, error)) {
    const auto size = std::filesystem::file_size(path, error);
    return error ? 0 : size;
  }
  uint64_t bytes = 0;
  for (std::filesystem::recursive_directory_iterator it(path, error), end; !error && it != end;
       it.increment(error)) {
    std::error_code ignored;
    if (it->is_regular_file(ignored)) bytes += it->file_size(ignored);
  }
  return bytes;
}

std::string name_of_path(const std::filesystem::path& path) {
  const auto whole = path.lexically_normal();
  return (whole.has_filename() ? whole.filename() : whole.parent_path().filename()).string();
}

/// What a map is made of and how.
MapJson identity_of(const SensorSetup& setup, size_t lidar, const MapSettings& settings) {
  MapJson json = make_manifest();
  json["sources"] = {{{"name", name_of_path(setup.path)}, {"bytes", bytes_of(setup.path)}}};
  json["lidar"] = setup.lidars[lidar].device.name;
  json["T_vehicle_lidar"] = encode(setup.rig.lidars[lidar].T_vehicle_lidar);
  json["settings"] = to_json(settings);
  return json;
}

/// Keyframes, clouds and fixes of a drive, as its sweeps and samples come.
class DriveMapper {
 public:
  DriveMapper(const MapFolder& folder, const Eigen::Isometry3d& T_vehicle_lidar,
              const MapSettings& settings)
      : folder_(folder),
        T_vehicle_lidar_(T_vehicle_lidar),
        submaps_(settings.keyframes, settings.submaps, T_vehicle_lidar) {}

  void add(const Sweep& sweep, const motion::DeskewedSweep& deskewed,
           const mapping::SweepMotion& motion) {
    ++sweeps_;
    air_.find(sweep);
    const auto ended = submaps_.add({air_.without(deskewed.x), deskewed.y, deskewed.z},
                                    sweep.reflectivity, motion);
    if (ended) store(*ended);
    if (submaps_.picker().started()) {
      poses_.push_back({motion.stamp, submaps_.picker().T_odom_vehicle()});
    }
  }

  void add(const GnssFix& fix) {
    if (fix.valid) fixes_.push_back(fix);
  }

  /// Writes the last cloud and the tables; `manifest` states them.
  Result<void> finish(MapJson manifest) {
    if (submaps_.picker().started()) store(submaps_.take());
    if (failed_) return tl::unexpected(*failed_);
    if (keyframes_.size() < 2) {
      return fail("no motion was found in its sweeps", "",
                  sweeps_ == 0 ? "the lidar has no sweeps" : "see infuse odometry");
    }
    std::vector<size_t> all(keyframes_.size());
    std::iota(all.begin(), all.end(), size_t{0});
    folder_.keep_clouds(all);  // an interrupted run of other content may have left some
    manifest["sweeps"] = sweeps_;
    manifest["unmeasured"] = submaps_.picker().unmeasured();
    manifest["unregistered"] = submaps_.picker().unregistered();
    return write_drive(folder_, std::move(manifest), keyframes_, nearest(), places_);
  }

  bool failed() const { return failed_.has_value(); }
  std::string progress() const {
    return fmt::format("{} sweeps, {} keyframes, {:.0f} m", sweeps_, keyframes_.size(),
                       submaps_.picker().distance_driven());
  }

 private:
  struct Pose {
    Stamp stamp;
    Eigen::Isometry3d T_odom_vehicle;
  };

  void store(const mapping::KeyframeSubmap& ended) {
    if (failed_) return;
    places_.push_back(places::describe_place(ended.submap.points(), T_vehicle_lidar_));
    auto written = folder_.write_cloud(keyframes_.size(), ended.submap);
    if (!written) {
      failed_ = written.error();
      return;
    }
    keyframes_.push_back({ended.keyframe, ended.submap.size(), *std::move(written)});
  }

  /// Where the vehicle was at a time, if sweeps on both sides tell.
  std::optional<Eigen::Isometry3d> pose_at(Stamp stamp) const {
    constexpr Duration kMaxGap{500'000'000};
    const auto after = std::lower_bound(poses_.begin(), poses_.end(), stamp,
                                        [](const Pose& p, Stamp s) { return p.stamp < s; });
    if (after == poses_.end() || after == poses_.begin()) return std::nullopt;
    const Pose& before = *std::prev(after);
    if (after->stamp - before.stamp > kMaxGap) return std::nullopt;
    return geometry::interpolate(
        before.T_odom_vehicle, after->T_odom_vehicle,
        to_seconds(stamp - before.stamp) / to_seconds(after->stamp - before.stamp));
  }

  size_t nearest_keyframe(Stamp stamp) const {
    const auto after =
        std::lower_bound(keyframes_.begin(), keyframes_.end(), stamp,
                         [](const MapKeyframe& k, Stamp s) { return k.keyframe.stamp < s; });
    const auto index = static_cast<size_t>(after - keyframes_.begin());
    if (index == 0) return 0;
    if (index == keyframes_.size()) return index - 1;
    const bool earlier =
        stamp - keyframes_[index - 1].keyframe.stamp < keyframes_[index].keyframe.stamp - stamp;
    return earlier ? index - 1 : index;
  }

  /// Of every keyframe the fix that is nearest to it.
  std::vector<MapFix> nearest() const {
    std::vector<MapFix> out;
    for (const GnssFix& fix : fixes_) {
      const auto T_odom_vehicle = pose_at(fix.stamp);
      if (!T_odom_vehicle) continue;
      MapFix placed;
      placed.fix = fix;
      placed.keyframe = nearest_keyframe(fix.stamp);
      placed.point = keyframes_[placed.keyframe].keyframe.T_odom_vehicle.inverse() *
                     T_odom_vehicle->translation();
      if (out.empty() || out.back().keyframe < placed.keyframe) {
        out.push_back(placed);
      } else if (out.back().keyframe == placed.keyframe &&
                 placed.point.norm() < out.back().point.norm()) {
        out.back() = placed;
      }
    }
    return out;
  }

  const MapFolder& folder_;
  Eigen::Isometry3d T_vehicle_lidar_;
  mapping::KeyframeSubmaps submaps_;
  features::AirReturns air_;
  std::vector<MapKeyframe> keyframes_;
  std::vector<places::PlaceDescriptor> places_;  // by keyframe
  std::vector<Pose> poses_;
  std::vector<GnssFix> fixes_;
  std::optional<Error> failed_;
  uint64_t sweeps_ = 0;
};

}  // namespace

Result<void> replay_to_map(const MapFolder& folder, SensorSetup& setup, size_t lidar,
                           const MapSettings& settings) {
  if (auto created = folder.create(); !created) return created;
  MapJson identity = identity_of(setup, lidar, settings);
  const auto replayed = folder.is_made_of(identity);
  if (!replayed) return tl::unexpected(replayed.error());
  if (*replayed) return {};
  folder.remove_results();
  DriveMapper mapper(folder, setup.rig.lidars[lidar].T_vehicle_lidar, settings);
  LidarReplay odometry(setup, lidar);
  ProgressLine line;
  const auto on_sweep = [&](const Sweep& sweep, const motion::DeskewedSweep& deskewed,
                            const mapping::SweepMotion& motion) {
    mapper.add(sweep, deskewed, motion);
    line.show(std::nullopt, mapper.progress());
  };
  play_lidar(
      setup, lidar, [&](const Sweep& sweep) { odometry.add_sweep(sweep); },
      [&](const VehicleSample& sample) {
        odometry.add_sample(sample);
        if (const auto* fix = std::get_if<GnssFix>(&sample)) mapper.add(*fix);
      },
      [&](const recording::DriveEvent& event) {
        odometry.process_due(event.stamp, on_sweep);
        return !mapper.failed();
      });
  odometry.finish(on_sweep);
  line.clear();
  auto finished = mapper.finish(std::move(identity));
  if (!finished && finished.error().where.empty()) {
    Error error = finished.error();
    error.where = setup.path.string();
    return tl::unexpected(error);
  }
  return finished;
}

}  // namespace infuse::daemon
