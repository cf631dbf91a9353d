#include <gtest/gtest.h>

#include "drivers/ros/messages.hpp"
#include "drivers/ros/schemas.hpp"
#include "drivers/ros/serialisation.hpp"

namespace infuse::ros {
namespace {

using Bytes = std::vector<uint8_t>;

TransformStamped make_transform() { return {{5, {1, 2}, "map"}, "b", {{1, 2, 3}, {0, 0, 0, 1}}}; }

// The bytes that the OMG's rules for plain CDR give: each number on a multiple of its size.
const Bytes kTransformLittle = {0, 1, 0, 0,                         // little-endian
                                1, 0, 0, 0, 2,   0,   0,    0,      // stamp
                                4, 0, 0, 0, 'm', 'a', 'p',  0,      // frame, with its NUL
                                2, 0, 0, 0, 'b', 0,                 // child
                                0, 0,                               // to a multiple of 8
                                0, 0, 0, 0, 0,   0,   0xF0, 0x3F,   // 1
                                0, 0, 0, 0, 0,   0,   0x00, 0x40,   // 2
                                0, 0, 0, 0, 0,   0,   0x08, 0x40,   // 3
                                0, 0, 0, 0, 0,   0,   0,    0,      // 0
                                0, 0, 0, 0, 0,   0,   0,    0,      // 0
                                0, 0, 0, 0, 0,   0,   0,    0,      // 0
                                0, 0, 0, 0, 0,   0,   0xF0, 0x3F};  // 1
const Bytes kTransformBig = {0,    0,    0, 0,                      // big-endian
                             0,    0,    0, 1, 0,   0,   0,   2,    //
                             0,    0,    0, 4, 'm', 'a', 'p', 0,    //
                             0,    0,    0, 2, 'b', 0,              //
                             0,    0,                               //
                             0x3F, 0xF0, 0, 0, 0,   0,   0,   0,    //
                             0x40, 0x00, 0, 0, 0,   0,   0,   0,    //
                             0x40, 0x08, 0, 0, 0,   0,   0,   0,    //
                             0,    0,    0, 0, 0,   0,   0,   0,    //
                             0,    0,    0, 0, 0,   0,   0,   0,    //
                             0,    0,    0, 0, 0,   0,   0,   0,    //
                             0x3F, 0xF0, 0, 0, 0,   0,   0,   0};
const Bytes kTransformRos1 = {5, 0, 0, 0,                        // sequence number
                              1, 0, 0, 0, 2,   0,   0,    0,     //
                              3, 0, 0, 0, 'm', 'a', 'p',         //
                              1, 0, 0, 0, 'b',                   //
                              0, 0, 0, 0, 0,   0,   0xF0, 0x3F,  //
                              0, 0, 0, 0, 0,   0,   0x00, 0x40,  //
                              0, 0, 0, 0, 0,   0,   0x08, 0x40,  //
                              0, 0, 0, 0, 0,   0,   0,    0,     //
                              0, 0, 0, 0, 0,   0,   0,    0,     //
                              0, 0, 0, 0, 0,   0,   0,    0,     //
                              0, 0, 0, 0, 0,   0,   0xF0, 0x3F};

TEST(RosMessages, BytesAreThoseOfTheRules) {
  Bytes bytes;
  encode(make_transform(), Encoding::kCdr, bytes);
  EXPECT_EQ(bytes, kTransformLittle);
  Encoder big(bytes, Encoding::kCdr, true);
  big(make_transform());
  EXPECT_EQ(bytes, kTransformBig);
  encode(make_transform(), Encoding::kRos1, bytes);
  EXPECT_EQ(bytes, kTransformRos1);
}

TEST(RosMessages, EveryEncodingIsDecoded) {
  for (const auto& [bytes, encoding] :
       {std::pair(kTransformLittle, Encoding::kCdr), std::pair(kTransformBig, Encoding::kCdr),
        std::pair(kTransformRos1, Encoding::kRos1)}) {
    const auto read = decode<TransformStamped>(bytes, encoding);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->header.stamp.stamp().ns(), 1'000'000'002);
    EXPECT_EQ(read->header.frame_id, "map");
    EXPECT_EQ(read->child_frame_id, "b");
    EXPECT_EQ(read->transform.translation.z, 3);
    EXPECT_EQ(read->transform.rotation.w, 1);
  }
}

TEST(RosMessages, BytesThatEndEarlyAreRefused) {
  for (const auto& [bytes, encoding] :
       {std::pair(kTransformLittle, Encoding::kCdr), std::pair(kTransformBig, Encoding::kCdr),
        std::pair(kTransformRos1, Encoding::kRos1)}) {
    for (size_t length = 0; length < bytes.size(); ++length) {
      EXPECT_FALSE(decode<TransformStamped>(std::span(bytes).first(length), encoding));
    }
  }
}

TEST(RosMessages, OtherRepresentationsAreRefused) {
  Bytes bytes = kTransformLittle;
  for (const int kind : {2, 3, 6, 7, 8, 9, 255}) {
    bytes[1] = static_cast<uint8_t>(kind);
    EXPECT_FALSE(decode<TransformStamped>(bytes, Encoding::kCdr));
  }
}

TEST(RosMessages, ClaimedCountsDoNotBecomeMemory) {
  Bytes bytes = {0, 1, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF, 1, 2, 3, 4};
  EXPECT_FALSE(decode<TfMessage>(bytes, Encoding::kCdr));
  EXPECT_FALSE(decode<UInt8MultiArray>(bytes, Encoding::kCdr));
}

template <class T>
void expect_same_after_reading(const T& message) {
  for (const auto encoding : {Encoding::kCdr, Encoding::kRos1}) {
    Bytes bytes, again;
    encode(message, encoding, bytes);
    const auto read = decode<T>(bytes, encoding);
    ASSERT_TRUE(read) << T::kName;
    encode(*read, encoding, again);
    EXPECT_EQ(again, bytes) << T::kName;
    for (size_t length = 0; length < bytes.size(); ++length) {
      decode<T>(std::span(bytes).first(length), encoding);  // does not crash
    }
    EXPECT_TRUE(schema_of(T::kName)) << T::kName;
  }
}

TEST(RosMessages, EveryMessageIsReadAsWritten) {
  const Header header = {1, {-3, 4}, "lidar"};
  const Bytes data(24, 7);
  expect_same_after_reading(TfMessage{{make_transform(), make_transform()}});
  expect_same_after_reading(TwistStamped{header, {{1, 2, 3}, {4, 5, 6}}});
  expect_same_after_reading(TwistWithCovarianceStamped{header, {{1, 2, 3}, {4, 5, 6}}, {7, 8}});
  expect_same_after_reading(Odometry{.header = header, .child_frame_id = "base_link"});
  expect_same_after_reading(Imu{.header = header, .angular_velocity = {1, 2, 3}});
  expect_same_after_reading(NavSatFix{.header = header, .status = -1, .latitude = 49});
  expect_same_after_reading(PointCloud2{.header = header,
                                        .height = 1,
                                        .width = 2,
                                        .point_fields = {{"x", 0, PointField::kFloat32, 1}},
                                        .point_step = 12,
                                        .row_step = 24,
                                        .data = data});
  expect_same_after_reading(Image{header, 2, 4, "bgr8", 0, 12, data});
  expect_same_after_reading(CompressedImage{header, "png", data});
  expect_same_after_reading(
      CameraInfo{.header = header, .distortion_model = "plumb_bob", .d = {1, 2, 3, 4, 5}});
  expect_same_after_reading(VelodyneScan{header, {{}, {{1, 2}, {}}}});
  expect_same_after_reading(UInt8MultiArray{{{"bytes", 24, 24}}, 0, data});
  expect_same_after_reading(DiagnosticArray{header, {{1, "a", "bb", "ccc", {{"k", "v"}}}}});
}

TEST(RosMessages, StampsBefore1970AreExact) {
  for (const int64_t ns :
       {int64_t{0}, int64_t{-1}, int64_t{-1'000'000'000}, int64_t{1'700'000'000'999'999'999}}) {
    EXPECT_EQ(Time::from(Stamp::from_ns(ns)).stamp().ns(), ns);
  }
}

TEST(RosMessages, TransformsAreRigidMotions) {
  const Eigen::Isometry3d motion =
      Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(2, Eigen::Vector3d(1, -2, 3).normalized());
  EXPECT_TRUE(to_isometry(to_transform(motion)).isApprox(motion, 1e-14));
}

TEST(RosSchemas, NamesTakeOneForm) {
  EXPECT_EQ(normalise_type("sensor_msgs/Imu"), "sensor_msgs/msg/Imu");
  EXPECT_EQ(normalise_type("sensor_msgs/msg/Imu"), "sensor_msgs/msg/Imu");
  EXPECT_EQ(normalise_type("sensor_msgs::msg::dds_::Imu_"), "sensor_msgs/msg/Imu");
  EXPECT_EQ(normalise_type("tf/tfMessage"), "tf2_msgs/msg/TFMessage");
  EXPECT_EQ(normalise_type(""), "");
}

TEST(RosSchemas, DefinitionsContainWhatTheyUse) {
  const auto text = schema_of("nav_msgs/msg/Odometry");
  ASSERT_TRUE(text);
  for (const char* contained : {"std_msgs/Header", "builtin_interfaces/Time", "geometry_msgs/Pose",
                                "geometry_msgs/Vector3", "geometry_msgs/Quaternion"}) {
    EXPECT_NE(text->find(std::string("MSG: ") + contained + "\n"), std::string::npos) << contained;
  }
  EXPECT_FALSE(schema_of("sensor_msgs/msg/None"));
}

}  // namespace
}  // namespace infuse::ros
