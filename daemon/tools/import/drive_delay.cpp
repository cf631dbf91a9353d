#include "daemon/tools/import/drive_delay.hpp"

#include <spdlog/fmt/fmt.h>

#include <Eigen/Core>
#include <variant>

#include "daemon/playback/play_lidar.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/drive_toml.hpp"
#include "fusion/motion/rate_delay.hpp"
#include "fusion/registration/lidar_trajectory.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kSweeps = 600;  // a minute

motion::SensorDelay measure(SensorSetup& setup) {
  motion::RateDelay delay;
  registration::LidarTrajectory trajectory(setup.rig.lidars[0].T_vehicle_lidar);
  size_t sweeps = 0;
  play_lidar(
      setup, 0,
      [&](const Sweep& sweep) {
        const registration::LidarOdometryResult& result = trajectory.add(sweep);
        if (result.usable()) delay.add(result.motion);
        ++sweeps;
      },
      [&](const VehicleSample& sample) {
        if (const auto* imu = std::get_if<ImuSample>(&sample))
          delay.add(imu->stamp, Eigen::Map<const Eigen::Vector3d>(imu->angular_velocity.data()));
      },
      [&](const recording::DriveEvent&) { return sweeps < kSweeps; });
  return delay.finish();
}

}  // namespace

void find_inertial_delay(const std::filesystem::path& folder, std::vector<Error>& notes) {
  auto drive = recording::Drive::open(folder);
  if (!drive) return notes.push_back(drive.error());
  recording::DriveDescription& description = drive->description;
  if (description.imu.empty() || !description.times_trusted || description.rig.lidars.empty() ||
      !description.rig.lidars[0].is_mounting_known())
    return;
  auto setup = open_drive(folder, {}, {});
  if (!setup) return notes.push_back(setup.error());
  const motion::SensorDelay delay = measure(*setup);
  const std::string file = (folder / description.imu).string();
  if (!delay.usable()) {
    notes.push_back(
        {std::string("how late its stamps are was not found: ") + delay.reason, file, ""});
    return;
  }
  description.imu_delay += from_seconds(delay.value);  // which was subtracted
  description.imu_delay_sigma = from_seconds(delay.sigma);
  if (auto written = recording::write_drive_toml(folder, description); !written) {
    notes.push_back(written.error());
    return;
  }
  notes.push_back(
      {fmt::format("its stamps are {:.1f} ± {:.1f} ms later than the motion of the lidar",
                   1e3 * to_seconds(description.imu_delay), 1e3 * delay.sigma),
       file, "drive.toml states it, and it is subtracted"});
}

}  // namespace infuse::daemon
