#pragma once

#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "daemon/pipeline/lidar_intake.hpp"
#include "daemon/pipeline/vehicle_intake.hpp"
#include "daemon/playback/deskewed_sweeps.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "drivers/measurement/camera_frame.hpp"

namespace infuse::python {

/// What is wanted of a recording.
struct PlayerOptions {
  bool sweeps = false, images = false, samples = false;
  std::optional<size_t> lidar{};   ///< only sweeps of this one
  std::optional<size_t> camera{};  ///< only images of this one
  bool deskew = false;             ///< sweeps of `lidar`, to their ends, as infused does
};

/// Plays a drive or a capture item by item, in the order of stamps.
class Player {
 public:
  using Measurement =
      std::variant<Sweep, CameraFrame, WheelOdometry, ImuSample, GnssFix, GyroReadings>;
  /// Name of the sensor, and what it measured.
  using Item = std::pair<std::string, Measurement>;

  Player(daemon::SensorSetup setup, const PlayerOptions& options);
  Player(const Player&) = delete;
  Player& operator=(const Player&) = delete;

  /// The next item, or nothing at the end. Errors: an image that cannot be read.
  Result<std::optional<Item>> next();

 private:
  Result<void> process(const recording::DriveEvent& event);
  void process(const recording::DatagramEvent& event);
  Result<void> process(const recording::ImageEvent& event, Stamp stamp);
  void add_sweep(size_t lidar, const Sweep& sweep);
  void add_sample(const daemon::VehicleSample& sample);
  void add_deskewed(const Sweep& sweep, const motion::DeskewedSweep& deskewed);
  void finish();

  daemon::SensorSetup setup_;
  PlayerOptions options_;
  std::deque<daemon::LidarIntake> lidars_;
  daemon::VehicleIntake vehicle_;
  std::optional<daemon::DeskewedSweeps> deskewed_;
  std::deque<Item> items_;
  bool ended_ = false;
};

}  // namespace infuse::python
