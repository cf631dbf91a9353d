#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/import/bag.hpp"
#include "drivers/import/bag_import.hpp"
#include "drivers/measurement/vehicle_samples.hpp"
#include "drivers/recording/drive.hpp"

namespace infuse::importers {

/// Samples of speed, inertial unit and GNSS of a recording: the topics that its selection names.
class BagSamples {
 public:
  /// `summary` names the topics, and receives counts and notes; it must outlive it.
  explicit BagSamples(BagImportSummary& summary) : summary_(summary) {}

  /// Sets the rotation from the frame of the inertial unit to the vehicle's; else the identity.
  void set_imu_rotation(const Eigen::Matrix3d& R_vehicle_imu) { R_vehicle_imu_ = R_vehicle_imu; }

  /// Adds a message; those of other topics are ignored.
  void add(const BagMessage& message, const std::string& topic);

  /// Number of messages that are cut or not finite.
  size_t unreadable() const { return unreadable_; }
  bool has_fixes() const { return !fixes_.empty(); }
  void drop_fixes() { fixes_.clear(); }

  /// Writes the samples, by stamp, to files in `drive`, and names those in `description`.
  Result<void> write(const std::filesystem::path& drive, recording::DriveDescription& description);

 private:
  /// Velocity over ground, m/s.
  struct Velocity {
    Stamp stamp;
    double east, north;
  };

  bool add_twist(const ros::Header& header, const ros::Twist& twist, Stamp log_time);
  bool add_speed(const BagMessage& message);
  bool add_imu(const BagMessage& message);
  bool add_fix(const BagMessage& message);
  bool add_velocity(const BagMessage& message);
  bool add_over_ground(const ros::Header& header, const ros::Twist& twist, Stamp log_time);
  /// Gives each fix the speed and course of the nearest velocity.
  void join_velocities();

  BagImportSummary& summary_;
  Eigen::Matrix3d R_vehicle_imu_ = Eigen::Matrix3d::Identity();
  std::vector<WheelOdometry> speeds_;
  std::vector<ImuSample> imu_;
  std::vector<GnssFix> fixes_;
  std::vector<Velocity> velocities_;
  size_t unreadable_ = 0;
};

}  // namespace infuse::importers
