#include "tests/study/motion/consistency_study.hpp"

#include <array>
#include <cstdio>
#include <ostream>

#include "tests/study/motion/drawn_drive.hpp"

namespace infuse::study {
namespace {

using namespace motion;

struct Combination {
  const char* name;
  Used used;
};

constexpr Combination kCombinations[] = {
    {"wheels, yaw rate", {.wheels = true, .bus = true}},
    {"wheels, gyros", {.wheels = true, .gyro = true}},
    {"GNSS", {.gnss = true}},
    {"GNSS, gyros", {.gyro = true, .gnss = true}},
    {"lidar", {.lidar = true}},
    {"lidar, wheels", {.wheels = true, .lidar = true}},
    {"lidar, wheels, yaw rate", {.wheels = true, .bus = true, .lidar = true}},
    {"lidar, gyros", {.gyro = true, .lidar = true}},
    {"lidar, GNSS", {.gnss = true, .lidar = true}},
    {"all", {.wheels = true, .bus = true, .gyro = true, .gnss = true, .lidar = true}},
};
constexpr double kLearned = 15, kEnd = 75;  // s; until the first what is constant is learned
constexpr std::array<double, 3> kSpans = {1, 10, 60};  // s

/// The planar part where nothing measures more.
double normalised(const geometry::Vector6& error, const geometry::Matrix6& covariance,
                  bool planar) {
  if (!planar) return error.dot(covariance.ldlt().solve(error)) / 6;
  const Eigen::Vector3d part = error.segment<3>(2);
  return part.dot(covariance.block<3, 3>(2, 2).ldlt().solve(part)) / 3;
}

struct Sum {
  double squares = 0;
  int count = 0, missing = 0;
};

void add_motions(const geometry::Trajectory& trajectory, const TrueDrive& drive, bool planar,
                 double span, Sum& sum) {
  for (double t = kLearned; t + span < kEnd + 0.5; t += span) {
    const auto motion = trajectory.between(seconds(t), seconds(t + span));
    if (!motion.usable()) {
      ++sum.missing;
      continue;
    }
    const Eigen::Isometry3d truth = drive.pose(t).inverse() * drive.pose(t + span);
    const geometry::Vector6 error = geometry::log(truth * motion.T_from_to.inverse());
    sum.squares += normalised(error, motion.covariance, planar);
    ++sum.count;
  }
}

}  // namespace

void write_consistency(std::ostream& out, uint64_t seed, int drives) {
  out << "| sources | 1 s | 10 s | 60 s |\n|---|---|---|---|\n";
  for (const auto& [name, used] : kCombinations) {
    std::array<Sum, kSpans.size()> sums;
    for (int i = 0; i < drives; ++i) {
      DrawnDrive drawn(seed + static_cast<uint64_t>(i));
      drawn.fault = kNothing;
      const TrueDrive drive =
          true_drive(drawn, kEnd + 1, unseen_motion(kEnd + 3, drawn.seed, OdometryOptions()));
      const geometry::Trajectory trajectory = drive_by(used, drawn, drive);
      const bool planar = !used.gyro && !used.lidar;
      for (size_t k = 0; k < kSpans.size(); ++k) {
        add_motions(trajectory, drive, planar, kSpans[k], sums[k]);
      }
    }
    out << "| " << name;
    for (const Sum& sum : sums) {
      char text[32];
      std::snprintf(text, sizeof text, " | %.2f", sum.squares / std::max(1, sum.count));
      out << text;
      if (sum.missing > 0) out << " (" << sum.missing << " without a pose)";
    }
    out << " |" << std::endl;
  }
}

}  // namespace infuse::study
