// The vehicle on the street map, on real sensors: KITTI odometry 04, 66 m of a street, and the
// OpenStreetMap extract around it, with nothing done by hand.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "daemon/streetmap/street_map_file.hpp"
#include "drivers/gnss/local_frame.hpp"
#include "drivers/import/kitti_import.hpp"
#include "drivers/measurement/angles.hpp"
#include "fusion/streetmap/planar_pose.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/folders.hpp"
#include "tests/real_data.hpp"

namespace infuse::daemon {
namespace {

using nlohmann::json;
using streetmap::PlanarPose;

constexpr double kChiSquared99 = 9.21;  // of two
constexpr size_t kRows = 51;            // of the truth: one a sweep

/// What a replay said about the pose on the map.
struct Tracked {
  int tracking = 0;      ///< poses that are TRACKING
  double metres = -1;    ///< driven until the first of them; below 0: never
  double rms = 0;        ///< m, of them
  double heading = 0;    ///< rad, rms of them
  int surely_wrong = 0;  ///< of them, those whose truth is outside the 99 % region
  double last = 0;       ///< m, error of the last pose, in whatever state
};

class RealStreet : public testing::Test {
 protected:
  // The import, the map and the truth; once for all replays.
  void make(const std::filesystem::path& data, const std::filesystem::path& extract) {
    const auto imported = importers::import_kitti(data / "sequences/04", drive_);
    ASSERT_TRUE(imported) << imported.error().message();
    ASSERT_EQ(imported->images, kRows);
    const ProgramResult made =
        run_shell_command(programs_folder() + "/infuse streetmap " + extract.string() + " -o " +
                          map_.string() + " 2>/dev/null");
    ASSERT_EQ(made.code, 0) << made.output;
    const auto opened = open_street_map_file(map_);
    ASSERT_TRUE(opened) << opened.error().message();
    const streetmap::MapFrame& on = opened->map.frame();
    const gnss::LocalFrame frame = gnss::make_local_frame(on.latitude, on.longitude);
    middle_ = {on.min_corner.x() + on.cell_size * opened->map.columns() / 2,
               on.min_corner.y() + on.cell_size * opened->map.rows() / 2, 0.3};
    std::ifstream times(data / "sequences/04/times.txt");
    for (double seconds = 0; times_.size() < kRows && times >> seconds;) times_.push_back(seconds);
    read_truth(data / "oxts-04.txt", frame);
    ASSERT_EQ(truth_.size(), kRows);
    ASSERT_EQ(times_.size(), kRows);
  }

  // Rows of the GPS/INS unit, which is mounted at x = −0.05, y = 0.32 m (KITTI's setup page).
  void read_truth(const std::filesystem::path& file, const gnss::LocalFrame& frame) {
    std::ifstream lines(file);
    for (std::string line; truth_.size() < kRows && std::getline(lines, line);) {
      std::istringstream numbers(line);
      double v[8];
      for (double& value : v) numbers >> value;
      const Eigen::Vector3d at = gnss::to_local(frame, v[0] * kDegree, v[1] * kDegree, 0);
      truth_.push_back(PlanarPose{at.x(), at.y(), v[5]}.compose({0.05, -0.32, 0}));
      velocity_.emplace_back(v[7], v[6]);
    }
  }

  PlanarPose truth_at(double seconds) const {
    size_t i = 0;
    while (i + 1 < kRows && times_[i + 1] <= seconds) ++i;
    PlanarPose pose = truth_[i];
    pose.x += velocity_[i].x() * (seconds - times_[i]);
    pose.y += velocity_[i].y() * (seconds - times_[i]);
    return pose;
  }

  double driven_until(double seconds) const {
    double metres = 0;
    for (size_t i = 1; i < kRows && times_[i] <= seconds; ++i) {
      metres += std::hypot(truth_[i].x - truth_[i - 1].x, truth_[i].y - truth_[i - 1].y);
    }
    return metres;
  }

  // Replays the drive from a pose that is stated within 2 m and 8 degrees.
  Tracked replay(const PlanarPose& start) {
    std::ofstream(folder_ / "infused.toml")
        << "[streetmap]\nmap = \"" << map_.string() << "\"\nx = " << start.x << "\ny = " << start.y
        << "\nyaw_deg = " << start.yaw / kDegree << "\nsigma = 2\nyaw_sigma_deg = 8\n";
    const auto reports = folder_ / "reports.jsonl";
    const ProgramResult run = run_shell_command(
        programs_folder() + "/infused --replay " + drive_.string() + " --config " +
        (folder_ / "infused.toml").string() + " --reports " + reports.string() + " --socket " +
        (folder_ / "s").string() + " 2>/dev/null");
    EXPECT_EQ(run.code, 0);
    Tracked tracked;
    std::ifstream lines(reports);
    for (std::string line; std::getline(lines, line);) {
      const json report = json::parse(line);
      if (report["class"] == "POSE" && report["frame"] == "map") add(report, tracked);
    }
    tracked.rms = std::sqrt(tracked.rms / std::max(tracked.tracking, 1));
    tracked.heading = std::sqrt(tracked.heading / std::max(tracked.tracking, 1));
    return tracked;
  }

  void add(const json& report, Tracked& tracked) const {
    const double seconds = 1e-9 * report["stamp"].get<double>();
    const PlanarPose truth = truth_at(seconds);
    const auto T = report["T_frame_vehicle"].get<std::vector<double>>();
    const auto C = report["covariance"].get<std::vector<double>>();
    const Eigen::Vector2d error(T[3] - truth.x, T[7] - truth.y);
    tracked.last = error.norm();
    if (report["state"] != "TRACKING") return;
    ++tracked.tracking;
    if (tracked.metres < 0) tracked.metres = driven_until(seconds);
    tracked.rms += error.squaredNorm();
    const double turned = wrap_angle(std::atan2(T[4], T[0]) - truth.yaw);
    tracked.heading += turned * turned;
    // The covariance is that of a left perturbation: d(x, y) = d(tx, ty) + drz × (x, y).
    Eigen::Matrix<double, 2, 6> J = Eigen::Matrix<double, 2, 6>::Zero();
    J.rightCols<3>().leftCols<2>().setIdentity();
    J(0, 2) = -T[7];
    J(1, 2) = T[3];
    const Eigen::Matrix2d region =
        J * Eigen::Map<const Eigen::Matrix<double, 6, 6>>(C.data()) * J.transpose();
    tracked.surely_wrong += error.dot(region.inverse() * error) > kChiSquared99;
  }

  PlanarPose start(double ahead, double left, double degrees) const {
    return truth_.at(0).compose({ahead, left, degrees * kDegree});
  }

  TemporaryFolder folder_;
  std::filesystem::path drive_ = folder_ / "drive", map_ = folder_ / "town.map";
  std::vector<double> times_;
  PlanarPose middle_;  // of the map
  std::vector<PlanarPose> truth_;
  std::vector<Eigen::Vector2d> velocity_;
};

#define MAKE_OR_SKIP()                                        \
  INFUSE_REAL_DATA_OR_SKIP(data, "drives/kitti_odometry_04"); \
  make(data, data / "04.osm.bz2");                            \
  if (HasFatalFailure()) return

TEST_F(RealStreet, IsTrackedFromStartsNearTheTruth) {
  MAKE_OR_SKIP();
  double sum = 0;
  const PlanarPose starts[] = {start(0, 0, 0), start(2, 0, 0), start(0, -2, 0), start(0, 0, -8)};
  for (const PlanarPose& from : starts) {
    const Tracked tracked = replay(from);
    const PlanarPose off = truth_[0].motion_to(from);
    const std::string which = std::to_string(off.x) + " m ahead, " + std::to_string(off.y) +
                              " m left, " + std::to_string(off.yaw / kDegree) + " degrees";
    EXPECT_GE(tracked.metres, 0) << which;
    EXPECT_LE(tracked.metres, 50) << which;
    EXPECT_EQ(tracked.surely_wrong, 0) << which;
    EXPECT_LT(tracked.rms, 0.8) << which;
    EXPECT_LT(tracked.heading, 1.5 * kDegree) << which;
    sum += tracked.rms;
    RecordProperty(which, std::to_string(tracked.rms));
  }
  EXPECT_LT(sum / std::size(starts), 0.5) << "the map itself is not better known";
}

TEST_F(RealStreet, IsNeverSurelyWrongFromOtherStarts) {
  MAKE_OR_SKIP();
  for (const PlanarPose& from :
       {start(-5, 0, 0), start(0, 10, 0), start(0, 0, 180), start(-180, 20, 0)}) {
    EXPECT_EQ(replay(from).surely_wrong, 0) << from.x << " " << from.y << " " << from.yaw;
  }
}

TEST_F(RealStreet, IsNotTrackedOnTheMapOfAnotherTown) {
  INFUSE_REAL_DATA_OR_SKIP(data, "drives/kitti_odometry_04");
  INFUSE_REAL_DATA_OR_SKIP(street, "street/07.osm.bz2");
  make(data, street);
  if (HasFatalFailure()) return;
  EXPECT_EQ(replay(middle_).tracking, 0);
}

}  // namespace
}  // namespace infuse::daemon
