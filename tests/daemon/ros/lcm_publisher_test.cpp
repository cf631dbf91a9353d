#include "daemon/ros/lcm_publisher.hpp"

#include <gtest/gtest.h>

#include "daemon/ros/report_messages.hpp"
#include "daemon/ros/sensor_messages.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "tests/drivers/lcm/lcm_receiver.hpp"

namespace infuse::daemon {
namespace {

MessageSetup one_lidar() {
  MessageSetup setup{.live = true};
  setup.rig.lidars = {LidarMount{.name = "top"}};
  setup.packet_makers = {&velodyne::maker()};
  setup.packet_metadata = {""};
  return setup;
}

TEST(LcmPublisher, PosesSweepsAndAlertsComeOutAsTheyWentIn) {
  lcm::LcmReceiver receiver;
  if (!receiver.works()) GTEST_SKIP() << "no multicast on the loopback";
  LcmSettings settings{.enabled = true, .to = receiver.options(), .max_points = 3};
  const auto publisher = LcmPublisher::create(settings, one_lidar());
  ASSERT_TRUE(publisher) << publisher.error().message();
  LcmPublisher& sink = **publisher;
  ReportMessages reports(sink);

  ASSERT_TRUE(
      reports.write(R"({"class":"POSE","stamp":1700000000000001000,"frame":"odom","usable":true,)"
                    R"("T_frame_vehicle":[0,-1,0,5,1,0,0,6,0,0,1,7,0,0,0,1],"covariance":[)"
                    R"(1,0,0,0,0,0,0,1,0,0,0,0,0,0,1,0,0,0,0,0,0,2,0,0,0,0,0,0,3,0,0,0,0,0,0,4],)"
                    R"("speed":5.5,"yaw_rate":0.25})"));
  auto pose = receiver.next();
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->channel, "INFUSE_POSE_odom");
  lcm::LcmFields p(pose->payload);
  EXPECT_EQ(p.number<uint64_t>(), lcm::kPoseFingerprint);
  EXPECT_EQ(p.number<int64_t>(), 1700000000000001);
  EXPECT_EQ(p.text(), "odom");
  for (const double expected : {5.0, 6.0, 7.0}) EXPECT_EQ(p.number<double>(), expected);
  for (const double expected : {std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5)})
    EXPECT_NEAR(p.number<double>(), expected, 1e-15);
  // ROS's order: position first. x moves by t + r × p: variance 2 + (z² of ry) + (y² of rz).
  EXPECT_EQ(p.number<double>(), 2 + 49 + 36);
  for (int k = 1; k < 36; ++k) p.number<double>();
  EXPECT_EQ(p.number<double>(), 5.5);
  EXPECT_EQ(p.number<double>(), 0.25);
  EXPECT_TRUE(p.at_end());

  SensorMessages messages(one_lidar(), sink);
  Sweep sweep;
  sweep.resize(5);
  for (size_t k = 0; k < 5; ++k) {
    sweep.x[k] = static_cast<float>(k);
    sweep.y[k] = -static_cast<float>(k);
    sweep.z[k] = 0.5F;
    sweep.range[k] = 1;
    sweep.reflectivity[k] = 0.25F;
    sweep.ring[k] = static_cast<uint16_t>(10 + k);
    sweep.column[k] = 0;
    sweep.time_offset_ns[k] = 0;
    sweep.return_kind[k] = {};
  }
  messages.write_deskewed(0, sweep, Stamp::from_ns(2'000'000));
  auto cloud = receiver.next();
  ASSERT_TRUE(cloud);
  EXPECT_EQ(cloud->channel, "INFUSE_SWEEP_top");
  lcm::LcmFields s(cloud->payload);
  EXPECT_EQ(s.number<uint64_t>(), lcm::kSweepFingerprint);
  EXPECT_EQ(s.number<int64_t>(), 2000);
  EXPECT_EQ(s.text(), "top");
  EXPECT_EQ(s.number<uint8_t>(), 1);
  ASSERT_EQ(s.number<int32_t>(), 3);  // every second of five
  for (const float expected : {0.0F, 2.0F, 4.0F}) EXPECT_EQ(s.number<float>(), expected);
  for (const float expected : {0.0F, -2.0F, -4.0F}) EXPECT_EQ(s.number<float>(), expected);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(s.number<float>(), 0.5F);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(s.number<float>(), 0.25F);
  for (const int expected : {10, 12, 14}) EXPECT_EQ(s.number<int16_t>(), expected);
  EXPECT_TRUE(s.at_end());

  ASSERT_TRUE(
      reports.write(R"({"class":"ALERT","stamp":3000000,"id":"a","device":"top","severity":"WARN",)"
                    R"("state":"raised","since":1,"what":"lost packets","advice":"look"})"));
  auto alert = receiver.next();
  ASSERT_TRUE(alert);
  EXPECT_EQ(alert->channel, "INFUSE_ALERT");
  lcm::LcmFields a(alert->payload);
  EXPECT_EQ(a.number<uint64_t>(), lcm::kAlertFingerprint);
  EXPECT_EQ(a.number<int64_t>(), 3000);
  for (const char* expected : {"a", "top", "WARN", "raised", "lost packets", "look"})
    EXPECT_EQ(a.text(), expected);
  EXPECT_TRUE(a.at_end());
  // HEALTH is no alert.
  ASSERT_TRUE(reports.write(
      R"({"class":"HEALTH","stamp":3,"level":"OK","sensors":[],"streams":[],"findings":[]})"));
  EXPECT_EQ(sink.sent(), 3u);
  EXPECT_EQ(sink.failed(), 0u);
}

}  // namespace
}  // namespace infuse::daemon
