#include "daemon/ros/report_messages.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "drivers/ros/messages.hpp"
#include "drivers/ros/serialisation.hpp"

namespace infuse::daemon {
namespace {

/// The transforms written to /tf.
class TransformSink : public MessageSink {
 public:
  bool wants(const std::string& topic) const override { return topic == "/tf"; }
  void add(const std::string&, const char*, Stamp, bool, std::span<const uint8_t> bytes) override {
    const auto message = ros::decode<ros::TfMessage>(bytes, ros::Encoding::kCdr);
    ASSERT_TRUE(message);
    for (const auto& transform : message->transforms) transforms.push_back(transform);
  }
  std::vector<ros::TransformStamped> transforms;
};

std::string pose_line(const char* frame, int64_t stamp, const Eigen::Isometry3d& T) {
  nlohmann::json report = {{"class", "POSE"}, {"stamp", stamp}, {"frame", frame}, {"usable", true}};
  for (int i = 0; i < 16; ++i) report["T_frame_vehicle"].push_back(T.matrix()(i / 4, i % 4));
  report["covariance"] = std::vector<double>(36, 0.0);
  return report.dump();
}

Eigen::Isometry3d to_rigid(const ros::TransformStamped& message) {
  const auto& [t, q] = message.transform;
  Eigen::Isometry3d T(Eigen::Quaterniond(q.w, q.x, q.y, q.z));
  T.translation() = Eigen::Vector3d(t.x, t.y, t.z);
  return T;
}

TEST(ReportMessages, TheTreeOfFramesGivesThePoseOnTheMap) {
  Eigen::Isometry3d T_odom_vehicle(
      Eigen::AngleAxisd(0.3, Eigen::Vector3d(0.1, 0.2, 1).normalized()));
  T_odom_vehicle.translation() = Eigen::Vector3d(5, 6, 0.5);
  Eigen::Isometry3d T_map_vehicle(Eigen::AngleAxisd(-1.1, Eigen::Vector3d::UnitZ()));
  T_map_vehicle.translation() = Eigen::Vector3d(-120, 80, 0);
  TransformSink sink;
  ReportMessages messages(sink);
  EXPECT_TRUE(messages.write(pose_line("map", 1'000'000'000, T_map_vehicle)));  // no odometry yet
  EXPECT_TRUE(sink.transforms.empty());
  EXPECT_TRUE(messages.write(pose_line("odom", 2'000'000'000, T_odom_vehicle)));
  EXPECT_TRUE(messages.write(pose_line("map", 2'000'000'000, T_map_vehicle)));
  EXPECT_TRUE(messages.write(pose_line("map", 3'000'000'000, T_map_vehicle)));  // none at that time
  ASSERT_EQ(sink.transforms.size(), 2u);
  const auto &odom = sink.transforms[0], &map = sink.transforms[1];
  EXPECT_EQ(odom.header.frame_id, "odom");
  EXPECT_EQ(odom.child_frame_id, "base_link");
  EXPECT_EQ(map.header.frame_id, "map");
  EXPECT_EQ(map.child_frame_id, "odom");
  EXPECT_TRUE((to_rigid(map) * to_rigid(odom)).isApprox(T_map_vehicle, 1e-9));
}

}  // namespace
}  // namespace infuse::daemon
