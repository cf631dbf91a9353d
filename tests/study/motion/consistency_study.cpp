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
// s: until the first what is constant is learned. Without a lidar what motions share is in the
// covariance of the whole path only: motions from the begin on are compared.
constexpr double kLearned = 15, kBegin = 1, kEnd = 75;
constexpr std::array<double, 3> kSpans = {1, 10, 60};  // s

/// Sums over motions: squared errors, and the variances that are stated of them.
struct Sums {
  double heading = 0, heading_variance = 0;    // rad²
  double position = 0, position_variance = 0;  // m², in the plane
  int missing = 0;
};

void add_motions(const geometry::Trajectory& trajectory, const TrueDrive& drive, bool lidar,
                 double span, Sums& sums) {
  const double first = lidar ? kLearned : kBegin, last = lidar ? kEnd : kBegin + span;
  for (double t = first; t + span < last + 0.5; t += span) {
    const auto motion = trajectory.between(seconds(t), seconds(t + span));
    if (!motion.usable()) {
      ++sums.missing;
      continue;
    }
    const Eigen::Isometry3d truth = drive.pose(t).inverse() * drive.pose(t + span);
    // At the end of the motion: a covariance is of its begin.
    const geometry::Matrix6 to_end = geometry::adjoint(motion.T_from_to.inverse());
    const geometry::Matrix6 covariance = to_end * motion.covariance * to_end.transpose();
    const geometry::Vector6 error = geometry::log(motion.T_from_to.inverse() * truth);
    sums.heading += error[2] * error[2];
    sums.heading_variance += covariance(2, 2);
    sums.position += error.segment<2>(3).squaredNorm();
    sums.position_variance += covariance(3, 3) + covariance(4, 4);
  }
}

}  // namespace

void write_consistency(std::ostream& out, uint64_t seed, int drives) {
  out << "| sources | 1 s: heading, position | 10 s | 60 s |\n|---|---|---|---|\n";
  for (const auto& [name, used] : kCombinations) {
    std::array<Sums, kSpans.size()> sums;
    for (int i = 0; i < drives; ++i) {
      DrawnDrive drawn(seed + static_cast<uint64_t>(i));
      drawn.fault = kNothing;
      const TrueDrive drive =
          true_drive(drawn, kEnd + 1, unseen_motion(kEnd + 3, drawn.seed, OdometryOptions()));
      const geometry::Trajectory trajectory = drive_by(used, drawn, drive);
      for (size_t k = 0; k < kSpans.size(); ++k) {
        add_motions(trajectory, drive, used.lidar, kSpans[k], sums[k]);
      }
    }
    out << "| " << name;
    for (const Sums& sum : sums) {
      char text[48];
      std::snprintf(text, sizeof text, " | %.2f, %.2f", sum.heading / sum.heading_variance,
                    sum.position / sum.position_variance);
      out << text;
      if (sum.missing > 0) out << " (" << sum.missing << " without a pose)";
    }
    out << " |" << std::endl;
  }
}

}  // namespace infuse::study
