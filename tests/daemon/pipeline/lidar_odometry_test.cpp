// A replay of a bare capture gets its odometry from the lidar alone.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "fixtures/scene/capture.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/real_data.hpp"

namespace infuse::daemon {
namespace {

// The receiver's GPRMC sentences state 14.8 to 15.2 m/s. They are not used here. The road holds
// little along its way: GICP finds no motion along it between two neighbouring sweeps.
TEST(LidarOdometry, RealHdl32ECaptureOfAMovingCarIsDeskewedAndHasItsSpeed) {
  INFUSE_REAL_DATA_OR_SKIP(path, "velodyne/hdl32e-moving.pcap");
  RunReplayOptions options;
  options.pipeline.odometry.use_gnss_speed = false;
  const auto result = run_replay(path, options);
  ASSERT_TRUE(result) << result.error().message();
  size_t sweeps = 0, deskewed = 0, poses = 0;
  for (const std::string& line : result->lines()) {
    const auto report = nlohmann::json::parse(line);
    if (report["class"] == "SWEEP") {
      ++sweeps;
      deskewed += report["deskewed"].get<bool>() ? 1 : 0;
    }
    if (report["class"] != "POSE" || sweeps < 3 || !report["usable"].get<bool>()) continue;
    ++poses;
    EXPECT_GT(report["speed"].get<double>(), 14.5) << "sweep " << sweeps;
    EXPECT_LT(report["speed"].get<double>(), 15.7) << "sweep " << sweeps;
  }
  ASSERT_GT(sweeps, 3U);
  // Nobody states how this lidar is mounted: it may move any way. The second sweep shows the
  // motion.
  EXPECT_EQ(sweeps, 6U);
  EXPECT_EQ(deskewed, 5U);
  EXPECT_EQ(poses, 4U);
}

// Along a straight street without an end nothing holds the lidar, so no motion is predicted well
// enough to deskew the next sweep. The local map is kept nevertheless: without it, errors across
// and of the heading would add up from sweep to sweep, to 20 mm and 0.6 mrad in 12 s.
TEST(LidarOdometry, AStreetWithoutAnEndLeavesOnlyTheWayFree) {
  const TemporaryFolder folder;
  fixtures::CaptureOptions options;
  options.duration = from_seconds(12);
  ASSERT_TRUE(fixtures::make_capture(folder / "x.pcap", options));
  const auto result = run_replay(folder / "x.pcap");
  ASSERT_TRUE(result) << result.error().message();
  size_t poses = 0;
  for (const std::string& line : result->lines()) {
    const auto report = nlohmann::json::parse(line);
    if (report["class"] != "POSE" || !report["usable"].get<bool>()) continue;
    ++poses;
    const auto& T = report["T_frame_vehicle"];
    EXPECT_NEAR(T[7].get<double>(), 0, 0.005) << poses;  // the lidar stands
    EXPECT_NEAR(T[4].get<double>(), 0, 4.5e-4) << poses;
  }
  EXPECT_GT(poses, 110U);
}

}  // namespace
}  // namespace infuse::daemon
