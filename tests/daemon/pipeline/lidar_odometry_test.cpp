// A replay of a bare capture gets its odometry from the lidar alone.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/real_data.hpp"

namespace infuse::daemon {
namespace {

// The receiver's GPRMC sentences state 14.8 to 15.2 m/s. They are not used here.
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
    EXPECT_LT(report["speed"].get<double>(), 15.5) << "sweep " << sweeps;
  }
  ASSERT_GT(sweeps, 3U);
  // Nobody states how this lidar is mounted: it may move any way. The second sweep shows the
  // motion.
  EXPECT_EQ(sweeps, 6U);
  EXPECT_EQ(deskewed, 5U);
  EXPECT_EQ(poses, 4U);
}

}  // namespace
}  // namespace infuse::daemon
