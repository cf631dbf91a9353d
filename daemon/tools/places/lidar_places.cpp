#include "daemon/tools/places/lidar_places.hpp"

#include <spdlog/fmt/fmt.h>

#include "daemon/command_line/progress_line.hpp"
#include "daemon/pipeline/odometry_plan.hpp"
#include "daemon/playback/camera_images.hpp"
#include "daemon/playback/deskewed_sweeps.hpp"
#include "daemon/playback/find_lidar.hpp"
#include "daemon/playback/play_lidar.hpp"
#include "fusion/features/air_returns.hpp"

namespace infuse::daemon {
namespace {

/// Describes the sweeps of one drive.
class Describer {
 public:
  Describer(const LidarPlacesRequest& request, const SensorSetup& setup, size_t lidar,
            std::vector<CameraImages> cameras)
      : request_(request),
        setup_(setup),
        T_vehicle_lidar_(setup.rig.lidars[lidar].T_vehicle_lidar),
        cameras_(std::move(cameras)) {}

  /// The exposure of the first camera that is nearest to the sweep's end, or its end.
  Stamp reference(const Sweep& sweep) const {
    const Stamp end = DeskewedSweeps::end_of(sweep);
    if (cameras_.empty()) return end;
    const Stamp exposure = cameras_.front().nearest(end).stamp;
    return distance_between(exposure, end) <= kMaxImageGap ? exposure : end;
  }

  Result<void> add(const Sweep& sweep, const motion::DeskewedSweep& deskewed) {
    air_.find(sweep);
    const geometry::PointsView points{air_.without(deskewed.x), deskewed.y, deskewed.z};
    out_.list.names.push_back(std::to_string(sweep.sequence));
    out_.list.stamps.push_back(reference(sweep));
    out_.shapes.push_back(places::describe_place(points, T_vehicle_lidar_));
    line_.show(0, fmt::format("{} sweeps", out_.shapes.size()));
    if (!request_.words) return {};
    auto images = read_nearest_images(cameras_, setup_, reference(sweep));
    if (!images) return tl::unexpected(images.error());
    std::vector<registration::ScanImage> views;
    for (size_t k = 0; k < images->cameras.size(); ++k)
      views.push_back({images->images[k], images->cameras[k]});
    out_.words.push_back(places::describe_scan(
        {{points, sweep.range, sweep.reflectivity, sweep.ring, sweep.column}, views},
        T_vehicle_lidar_));
    return {};
  }

  LidarPlaces take() {
    line_.clear();
    return std::move(out_);
  }

 private:
  const LidarPlacesRequest& request_;
  const SensorSetup& setup_;
  Eigen::Isometry3d T_vehicle_lidar_;
  std::vector<CameraImages> cameras_;
  features::AirReturns air_;
  ProgressLine line_;
  LidarPlaces out_;
};

}  // namespace

Result<LidarPlaces> read_lidar_places(const std::string& path, const LidarPlacesRequest& request) {
  auto setup = open_drive(path, {}, {});
  if (!setup) return tl::unexpected(setup.error());
  const auto lidar = find_lidar(*setup, request.lidar);
  if (!lidar) return tl::unexpected(lidar.error());
  std::vector<CameraImages> cameras;
  if (request.grey) {
    auto listed = list_camera_images(path, setup->rig.lidars[*lidar].name);
    if (!listed) return tl::unexpected(listed.error());
    cameras = std::move(*listed);
  }
  Describer describer(request, *setup, *lidar, std::move(cameras));
  DeskewedSweeps sweeps(plan_odometry({}, *setup, *lidar),
                        setup->rig.lidars[*lidar].T_vehicle_lidar,
                        [&](const Sweep& sweep) { return describer.reference(sweep); });
  Result<void> described;
  const auto on_deskewed = [&](const Sweep& sweep, const motion::DeskewedSweep& deskewed) {
    if (described && sweep.sequence % request.every == 0)
      described = describer.add(sweep, deskewed);
  };
  play_lidar(
      *setup, *lidar, [&](Sweep& sweep) { sweeps.add_sweep(sweep); },
      [&](const VehicleSample& sample) { sweeps.add_sample(sample); },
      [&](const recording::DriveEvent& event) {
        sweeps.process_due(event.stamp, on_deskewed);
        return described.has_value();
      });
  sweeps.finish(on_deskewed);
  if (!described) return tl::unexpected(described.error());
  LidarPlaces out = describer.take();
  if (out.shapes.empty()) return fail("there is no sweep", path);
  return out;
}

}  // namespace infuse::daemon
