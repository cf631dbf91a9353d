// Another visit to the streets of a map: it is located there.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/daemon/drive/block_map.hpp"
#include "tests/daemon/schema.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

/// Errors of poses on the map, m: relative to the nearest keyframe, as the truth of both visits has
/// it. What the map itself is wrong by does not count.
std::vector<double> errors_on_map(const std::vector<geometry::StampedPose>& on_map,
                                  const std::vector<geometry::StampedPose>& truth,
                                  const std::vector<geometry::StampedPose>& keyframes,
                                  const std::vector<geometry::StampedPose>& keyframe_truth) {
  const auto pairs = motion::pair_by_time(on_map, truth);
  const auto of_map = motion::pair_by_time(keyframes, keyframe_truth);
  std::vector<double> errors;
  for (const auto& pose : pairs) {
    const auto nearest =
        std::min_element(of_map.begin(), of_map.end(), [&](const auto& a, const auto& b) {
          const Eigen::Vector3d p = pose.estimate.translation();
          return (a.estimate.translation() - p).norm() < (b.estimate.translation() - p).norm();
        });
    errors.push_back(((nearest->truth.inverse() * pose.truth).translation() -
                      (nearest->estimate.inverse() * pose.estimate).translation())
                         .head<2>()
                         .norm());
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

// From nothing, against the direction in which the map was driven.
TEST_F(BlockMap, AnotherVisitIsFoundOnTheMapAndTracked) {
  const std::string other = (made_->folder / "other").string();
  ASSERT_TRUE(simulate(other, visit("[110, 112, 104, 100]", 20)));
  const std::string track = (made_->folder / "on_map.tum").string();
  const ProgramResult run =
      Made::infuse("map locate " + made_->map() + " " + other + " -o " + track + " --json");
  ASSERT_EQ(run.code, 0) << run.output;
  EXPECT_TRUE(is_result(run.output, "map-locate"));
  const auto summary = nlohmann::json::parse(run.output);
  EXPECT_LT(summary["found_after_s"], 10) << run.output;
  EXPECT_GT(summary["tracking"], 100) << run.output;
  const auto errors = errors_on_map(read_poses(track), read_poses(other + "/truth/poses.tum"),
                                    read_poses(made_->map() + "/trajectory.tum"), made_->truth);
  ASSERT_FALSE(errors.empty());
  EXPECT_LT(errors[errors.size() / 2], 0.1);
  EXPECT_LT(errors.back(), 0.4);

  // The daemon does the same, to the same bytes at any rate.
  const auto file = [&](const std::string& name) { return (made_->folder / name).string(); };
  write_file(file("infused.toml"), "[map]\ndirectory = \"map\"\n");
  for (const auto& [reports, rate] : {std::pair{"a.jsonl", ""}, {"b.jsonl", " --rate 8"}}) {
    const ProgramResult replay = Made::infused(
        "--replay " + other + " --config " + file("infused.toml") + " --socket " + file("s") +
        " --trajectory " + file("live.tum") + " --reports " + file(reports) + rate);
    ASSERT_EQ(replay.code, 0) << replay.output;
  }
  const std::string reports = read_file(file("a.jsonl"));
  EXPECT_EQ(reports, read_file(file("b.jsonl")));
  std::vector<geometry::StampedPose> on_map;
  std::istringstream lines(reports);
  for (std::string line; std::getline(lines, line);) {
    const auto report = nlohmann::json::parse(line);
    if (report["class"] != "POSE" || report["frame"] != "map" || !report["usable"]) continue;
    EXPECT_EQ(report["state"], "TRACKING");
    geometry::StampedPose pose;
    pose.stamp = Stamp::from_ns(report["stamp"].get<int64_t>());
    for (int i = 0; i < 12; ++i) {
      pose.T_odom_vehicle.matrix()(i / 4, i % 4) =
          report["T_frame_vehicle"][static_cast<size_t>(i)].get<double>();
    }
    on_map.push_back(pose);
  }
  EXPECT_GT(on_map.size(), 90U);
  EXPECT_EQ(read_poses(file("live.tum")).size(),
            on_map.size());  // the trajectory is in the map, too
  const auto live = errors_on_map(on_map, read_poses(other + "/truth/poses.tum"),
                                  read_poses(made_->map() + "/trajectory.tum"), made_->truth);
  ASSERT_FALSE(live.empty());
  EXPECT_LT(live[live.size() / 2], 0.1);
  EXPECT_LT(live.back(), 0.5);
}

TEST_F(BlockMap, ADriveElsewhereIsNotFoundOnTheMap) {
  const std::string other = (made_->folder / "elsewhere").string();
  std::string scenario = visit("[100, 104]", 12);
  const size_t begin = scenario.find("map ="), end = scenario.find("build_radius_m");
  scenario.replace(begin, end - begin, "town_size_m = 500\nroute_length_m = 300\n");
  ASSERT_TRUE(simulate(other, scenario));
  const ProgramResult run = Made::infuse("map locate " + made_->map() + " " + other);
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.output, HasSubstr("not found on the map"));
}

}  // namespace
}  // namespace infuse::daemon
