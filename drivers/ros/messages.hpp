#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/measurement/stamp.hpp"

/// Messages of ROS 2's common_interfaces, tf2_msgs and velodyne_msgs that infuse reads and writes.
/// Each has the fields of its definition in their order (`schema_of`), and `fields(archive)`, which
/// hands them to a `Decoder` or an `Encoder`. Spans are not copied.
namespace infuse::ros {

/// builtin_interfaces/Time
struct Time {
  int32_t sec = 0;
  uint32_t nanosec = 0;
  void fields(auto& archive) { archive(sec, nanosec); }

  static Time from(Stamp stamp) {
    constexpr int64_t kSecond = 1'000'000'000;
    const int64_t rest = (stamp.ns() % kSecond + kSecond) % kSecond;
    return {static_cast<int32_t>((stamp.ns() - rest) / kSecond), static_cast<uint32_t>(rest)};
  }
  Stamp stamp() const {
    return Stamp::from_ns(static_cast<int64_t>(sec) * 1'000'000'000 +
                          static_cast<int64_t>(nanosec));
  }
};

/// std_msgs/Header
struct Header {
  uint32_t sequence = 0;  ///< ROS 1 only
  Time stamp;
  std::string frame_id;
  void fields(auto& archive) {
    if (archive.has_sequences()) archive(sequence);
    archive(stamp, frame_id);
  }
};

/// geometry_msgs/Vector3 and Point
struct Vector3 {
  double x = 0, y = 0, z = 0;
  void fields(auto& archive) { archive(x, y, z); }
};

/// geometry_msgs/Quaternion
struct Quaternion {
  double x = 0, y = 0, z = 0, w = 1;
  void fields(auto& archive) { archive(x, y, z, w); }
};

/// geometry_msgs/Transform and Pose
struct Transform {
  Vector3 translation;
  Quaternion rotation;
  void fields(auto& archive) { archive(translation, rotation); }
};

/// geometry_msgs/TransformStamped: T_header.frame_id_child_frame_id.
struct TransformStamped {
  static constexpr const char* kName = "geometry_msgs/msg/TransformStamped";
  Header header;
  std::string child_frame_id;
  Transform transform;
  void fields(auto& archive) { archive(header, child_frame_id, transform); }
};

/// tf2_msgs/TFMessage; in ROS 1 also tf/tfMessage.
struct TfMessage {
  static constexpr const char* kName = "tf2_msgs/msg/TFMessage";
  std::vector<TransformStamped> transforms;
  void fields(auto& archive) { archive(transforms); }
};

/// geometry_msgs/Twist
struct Twist {
  Vector3 linear, angular;
  void fields(auto& archive) { archive(linear, angular); }
};

/// geometry_msgs/TwistStamped
struct TwistStamped {
  static constexpr const char* kName = "geometry_msgs/msg/TwistStamped";
  Header header;
  Twist twist;
  void fields(auto& archive) { archive(header, twist); }
};

/// geometry_msgs/TwistWithCovarianceStamped
struct TwistWithCovarianceStamped {
  static constexpr const char* kName = "geometry_msgs/msg/TwistWithCovarianceStamped";
  Header header;
  Twist twist;
  std::array<double, 36> covariance{};  ///< by row: x y z, rotation about x y z
  void fields(auto& archive) { archive(header, twist, covariance); }
};

/// nav_msgs/Odometry: the pose is in header.frame_id, the twist in child_frame_id.
struct Odometry {
  static constexpr const char* kName = "nav_msgs/msg/Odometry";
  Header header;
  std::string child_frame_id;
  Transform pose;
  std::array<double, 36> pose_covariance{};  ///< by row: x y z, rotation about x y z
  Twist twist;
  std::array<double, 36> twist_covariance{};
  void fields(auto& archive) {
    archive(header, child_frame_id, pose, pose_covariance, twist, twist_covariance);
  }
};

/// sensor_msgs/Imu. A covariance that begins with −1: not measured.
struct Imu {
  static constexpr const char* kName = "sensor_msgs/msg/Imu";
  Header header;
  Quaternion orientation;
  std::array<double, 9> orientation_covariance{};
  Vector3 angular_velocity;  ///< rad/s
  std::array<double, 9> angular_velocity_covariance{};
  Vector3 linear_acceleration;  ///< m/s²
  std::array<double, 9> linear_acceleration_covariance{};
  void fields(auto& archive) {
    archive(header, orientation, orientation_covariance, angular_velocity,
            angular_velocity_covariance, linear_acceleration, linear_acceleration_covariance);
  }
};

/// sensor_msgs/NavSatFix
struct NavSatFix {
  static constexpr const char* kName = "sensor_msgs/msg/NavSatFix";
  Header header;
  int8_t status = 0;  ///< −1 no fix, 0 fix, 1 and 2 augmented
  uint16_t service = 0;
  double latitude = 0;   ///< degrees
  double longitude = 0;  ///< degrees
  double altitude = 0;   ///< m above the ellipsoid; NaN if unknown
  std::array<double, 9> position_covariance{};
  uint8_t position_covariance_type = 0;
  void fields(auto& archive) {
    archive(header, status, service, latitude, longitude, altitude, position_covariance,
            position_covariance_type);
  }
};

/// sensor_msgs/PointField
struct PointField {
  enum Type : uint8_t {
    kInt8 = 1,
    kUint8 = 2,
    kInt16 = 3,
    kUint16 = 4,
    kInt32 = 5,
    kUint32 = 6,
    kFloat32 = 7,
    kFloat64 = 8,
  };
  std::string name;
  uint32_t offset = 0;  ///< in a point, bytes
  uint8_t datatype = 0;
  uint32_t count = 0;
  void fields(auto& archive) { archive(name, offset, datatype, count); }
};

/// sensor_msgs/PointCloud2
struct PointCloud2 {
  static constexpr const char* kName = "sensor_msgs/msg/PointCloud2";
  Header header;
  uint32_t height = 0, width = 0;
  std::vector<PointField> point_fields;
  bool is_bigendian = false;
  uint32_t point_step = 0, row_step = 0;  ///< bytes
  std::span<const uint8_t> data;
  bool is_dense = false;
  void fields(auto& archive) {
    archive(header, height, width, point_fields, is_bigendian, point_step, row_step, data,
            is_dense);
  }
};

/// sensor_msgs/Image
struct Image {
  static constexpr const char* kName = "sensor_msgs/msg/Image";
  Header header;
  uint32_t height = 0, width = 0;  ///< pixels
  std::string encoding;            ///< "bgr8", "mono8", "bayer_rggb8", …
  uint8_t is_bigendian = 0;
  uint32_t step = 0;  ///< bytes of a row
  std::span<const uint8_t> data;
  void fields(auto& archive) { archive(header, height, width, encoding, is_bigendian, step, data); }
};

/// sensor_msgs/CompressedImage
struct CompressedImage {
  static constexpr const char* kName = "sensor_msgs/msg/CompressedImage";
  Header header;
  std::string format;  ///< "png", "jpeg", or "bgr8; jpeg compressed bgr8" and the like
  std::span<const uint8_t> data;
  void fields(auto& archive) { archive(header, format, data); }
};

/// sensor_msgs/RegionOfInterest
struct RegionOfInterest {
  uint32_t x_offset = 0, y_offset = 0, height = 0, width = 0;
  bool do_rectify = false;
  void fields(auto& archive) { archive(x_offset, y_offset, height, width, do_rectify); }
};

/// sensor_msgs/CameraInfo
struct CameraInfo {
  static constexpr const char* kName = "sensor_msgs/msg/CameraInfo";
  Header header;
  uint32_t height = 0, width = 0;  ///< pixels
  std::string distortion_model;    ///< "plumb_bob", "equidistant", "rational_polynomial"
  std::vector<double> d;
  std::array<double, 9> k{};   ///< of the image as measured, by row
  std::array<double, 9> r{};   ///< rotation that rectifies
  std::array<double, 12> p{};  ///< of the rectified image
  uint32_t binning_x = 0, binning_y = 0;
  RegionOfInterest roi;
  void fields(auto& archive) {
    archive(header, height, width, distortion_model, d, k, r, p, binning_x, binning_y, roi);
  }
};

/// velodyne_msgs/VelodynePacket
struct VelodynePacket {
  Time stamp;
  std::array<uint8_t, 1206> data{};
  void fields(auto& archive) { archive(stamp, data); }
};

/// velodyne_msgs/VelodyneScan: the packets of a turn.
struct VelodyneScan {
  static constexpr const char* kName = "velodyne_msgs/msg/VelodyneScan";
  Header header;
  std::vector<VelodynePacket> packets;
  void fields(auto& archive) { archive(header, packets); }
};

/// pandar_msgs/PandarPacket, of Hesai's driver
struct PandarPacket {
  Time stamp;
  std::array<uint8_t, 1500> data{};
  uint32_t size = 0;  ///< bytes of `data` that are the packet
  void fields(auto& archive) { archive(stamp, data, size); }
};

/// pandar_msgs/PandarScan: the packets of a turn.
struct PandarScan {
  static constexpr const char* kName = "pandar_msgs/msg/PandarScan";
  Header header;
  std::vector<PandarPacket> packets;
  void fields(auto& archive) { archive(header, packets); }
};

/// nebula_msgs/NebulaPacket, of Nebula's drivers of several makers
struct NebulaPacket {
  Time stamp;
  std::span<const uint8_t> data;
  void fields(auto& archive) { archive(stamp, data); }
};

/// nebula_msgs/NebulaPackets: the packets of a turn.
struct NebulaPackets {
  static constexpr const char* kName = "nebula_msgs/msg/NebulaPackets";
  Header header;
  std::vector<NebulaPacket> packets;
  void fields(auto& archive) { archive(header, packets); }
};

/// rslidar_msg/RslidarPacket, of RoboSense's driver: a data or an information packet.
struct RslidarPacket {
  static constexpr const char* kName = "rslidar_msg/msg/RslidarPacket";
  Header header;
  uint8_t is_information = 0;  ///< is_difop
  uint8_t is_frame_begin = 0;
  std::span<const uint8_t> data;
  void fields(auto& archive) { archive(header, is_information, is_frame_begin, data); }
};

/// rslidar_msgs/rslidarPacket, of RoboSense's driver until 2020
struct OldRslidarPacket {
  Time stamp;
  std::array<uint8_t, 1248> data{};
  void fields(auto& archive) { archive(stamp, data); }
};

/// rslidar_msgs/rslidarScan: the packets of a turn.
struct OldRslidarScan {
  Header header;
  std::vector<OldRslidarPacket> packets;
  void fields(auto& archive) { archive(header, packets); }
};

/// ouster_sensor_msgs/PacketMsg, of Ouster's driver: a packet of either kind, without a stamp.
struct OusterPacket {
  static constexpr const char* kName = "ouster_sensor_msgs/msg/PacketMsg";
  std::span<const uint8_t> buffer;
  void fields(auto& archive) { archive(buffer); }
};

/// std_msgs/String
struct String {
  static constexpr const char* kName = "std_msgs/msg/String";
  std::string data;
  void fields(auto& archive) { archive(data); }
};

/// std_msgs/MultiArrayDimension
struct MultiArrayDimension {
  std::string label;
  uint32_t size = 0, stride = 0;
  void fields(auto& archive) { archive(label, size, stride); }
};

/// std_msgs/UInt8MultiArray
struct UInt8MultiArray {
  static constexpr const char* kName = "std_msgs/msg/UInt8MultiArray";
  std::vector<MultiArrayDimension> dimensions;
  uint32_t data_offset = 0;
  std::span<const uint8_t> data;
  void fields(auto& archive) { archive(dimensions, data_offset, data); }
};

/// diagnostic_msgs/KeyValue
struct KeyValue {
  std::string key, value;
  void fields(auto& archive) { archive(key, value); }
};

/// diagnostic_msgs/DiagnosticStatus
struct DiagnosticStatus {
  uint8_t level = 0;  ///< 0 ok, 1 warning, 2 error, 3 stale
  std::string name, message, hardware_id;
  std::vector<KeyValue> values;
  void fields(auto& archive) { archive(level, name, message, hardware_id, values); }
};

/// diagnostic_msgs/DiagnosticArray
struct DiagnosticArray {
  static constexpr const char* kName = "diagnostic_msgs/msg/DiagnosticArray";
  Header header;
  std::vector<DiagnosticStatus> status;
  void fields(auto& archive) { archive(header, status); }
};

/// Returns the transform as a rigid motion; the quaternion is normalised. Not finite numbers stay.
Eigen::Isometry3d to_isometry(const Transform& transform);

/// Returns the rigid motion as a transform.
Transform to_transform(const Eigen::Isometry3d& motion);

}  // namespace infuse::ros
