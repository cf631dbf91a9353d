#include "drivers/ros/schemas.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace infuse::ros {
namespace {

struct Definition {
  std::string_view name;
  std::string_view text;  ///< without comments
  std::vector<std::string_view> contains;
};

// Of ROS 2 Humble.
const std::vector<Definition>& definitions() {
  static const std::vector<Definition> all = {
      {"builtin_interfaces/msg/Time", "int32 sec\nuint32 nanosec\n", {}},
      {"std_msgs/msg/Header",
       "builtin_interfaces/Time stamp\nstring frame_id\n",
       {"builtin_interfaces/msg/Time"}},
      {"geometry_msgs/msg/Vector3", "float64 x\nfloat64 y\nfloat64 z\n", {}},
      {"geometry_msgs/msg/Point", "float64 x\nfloat64 y\nfloat64 z\n", {}},
      {"geometry_msgs/msg/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n", {}},
      {"geometry_msgs/msg/Transform",
       "Vector3 translation\nQuaternion rotation\n",
       {"geometry_msgs/msg/Vector3", "geometry_msgs/msg/Quaternion"}},
      {"geometry_msgs/msg/Pose",
       "Point position\nQuaternion orientation\n",
       {"geometry_msgs/msg/Point", "geometry_msgs/msg/Quaternion"}},
      {"geometry_msgs/msg/PoseWithCovariance",
       "Pose pose\nfloat64[36] covariance\n",
       {"geometry_msgs/msg/Pose"}},
      {"geometry_msgs/msg/Twist",
       "Vector3 linear\nVector3 angular\n",
       {"geometry_msgs/msg/Vector3"}},
      {"geometry_msgs/msg/TwistWithCovariance",
       "Twist twist\nfloat64[36] covariance\n",
       {"geometry_msgs/msg/Twist"}},
      {"geometry_msgs/msg/TransformStamped",
       "std_msgs/Header header\nstring child_frame_id\nTransform transform\n",
       {"std_msgs/msg/Header", "geometry_msgs/msg/Transform"}},
      {"geometry_msgs/msg/TwistStamped",
       "std_msgs/Header header\nTwist twist\n",
       {"std_msgs/msg/Header", "geometry_msgs/msg/Twist"}},
      {"geometry_msgs/msg/TwistWithCovarianceStamped",
       "std_msgs/Header header\nTwistWithCovariance twist\n",
       {"std_msgs/msg/Header", "geometry_msgs/msg/TwistWithCovariance"}},
      {"tf2_msgs/msg/TFMessage",
       "geometry_msgs/TransformStamped[] transforms\n",
       {"geometry_msgs/msg/TransformStamped"}},
      {"nav_msgs/msg/Odometry",
       "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
       "geometry_msgs/TwistWithCovariance twist\n",
       {"std_msgs/msg/Header", "geometry_msgs/msg/PoseWithCovariance",
        "geometry_msgs/msg/TwistWithCovariance"}},
      {"sensor_msgs/msg/Imu",
       "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n"
       "float64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\n"
       "float64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\n"
       "float64[9] linear_acceleration_covariance\n",
       {"std_msgs/msg/Header", "geometry_msgs/msg/Quaternion", "geometry_msgs/msg/Vector3"}},
      {"sensor_msgs/msg/NavSatStatus",
       "int8 STATUS_NO_FIX = -1\nint8 STATUS_FIX = 0\nint8 STATUS_SBAS_FIX = 1\n"
       "int8 STATUS_GBAS_FIX = 2\nint8 status\nuint16 SERVICE_GPS = 1\n"
       "uint16 SERVICE_GLONASS = 2\nuint16 SERVICE_COMPASS = 4\nuint16 SERVICE_GALILEO = 8\n"
       "uint16 service\n",
       {}},
      {"sensor_msgs/msg/NavSatFix",
       "std_msgs/Header header\nNavSatStatus status\nfloat64 latitude\nfloat64 longitude\n"
       "float64 altitude\nfloat64[9] position_covariance\nuint8 COVARIANCE_TYPE_UNKNOWN = 0\n"
       "uint8 COVARIANCE_TYPE_APPROXIMATED = 1\nuint8 COVARIANCE_TYPE_DIAGONAL_KNOWN = 2\n"
       "uint8 COVARIANCE_TYPE_KNOWN = 3\nuint8 position_covariance_type\n",
       {"std_msgs/msg/Header", "sensor_msgs/msg/NavSatStatus"}},
      {"sensor_msgs/msg/PointField",
       "uint8 INT8 = 1\nuint8 UINT8 = 2\nuint8 INT16 = 3\nuint8 UINT16 = 4\nuint8 INT32 = 5\n"
       "uint8 UINT32 = 6\nuint8 FLOAT32 = 7\nuint8 FLOAT64 = 8\nstring name\nuint32 offset\n"
       "uint8 datatype\nuint32 count\n",
       {}},
      {"sensor_msgs/msg/PointCloud2",
       "std_msgs/Header header\nuint32 height\nuint32 width\nPointField[] fields\n"
       "bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n",
       {"std_msgs/msg/Header", "sensor_msgs/msg/PointField"}},
      {"sensor_msgs/msg/Image",
       "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\n"
       "uint8 is_bigendian\nuint32 step\nuint8[] data\n",
       {"std_msgs/msg/Header"}},
      {"sensor_msgs/msg/CompressedImage",
       "std_msgs/Header header\nstring format\nuint8[] data\n",
       {"std_msgs/msg/Header"}},
      {"sensor_msgs/msg/RegionOfInterest",
       "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n",
       {}},
      {"sensor_msgs/msg/CameraInfo",
       "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\n"
       "float64[] d\nfloat64[9] k\nfloat64[9] r\nfloat64[12] p\nuint32 binning_x\n"
       "uint32 binning_y\nRegionOfInterest roi\n",
       {"std_msgs/msg/Header", "sensor_msgs/msg/RegionOfInterest"}},
      {"velodyne_msgs/msg/VelodynePacket",
       "builtin_interfaces/Time stamp\nuint8[1206] data\n",
       {"builtin_interfaces/msg/Time"}},
      {"velodyne_msgs/msg/VelodyneScan",
       "std_msgs/Header header\nVelodynePacket[] packets\n",
       {"std_msgs/msg/Header", "velodyne_msgs/msg/VelodynePacket"}},
      {"pandar_msgs/msg/PandarPacket",
       "builtin_interfaces/Time stamp\nuint8[1500] data\nuint32 size\n",
       {"builtin_interfaces/msg/Time"}},
      {"pandar_msgs/msg/PandarScan",
       "std_msgs/Header header\nPandarPacket[] packets\n",
       {"std_msgs/msg/Header", "pandar_msgs/msg/PandarPacket"}},
      {"rslidar_msg/msg/RslidarPacket",
       "std_msgs/Header header\nuint8 is_difop\nuint8 is_frame_begin\nuint8[] data\n",
       {"std_msgs/msg/Header"}},
      {"ouster_sensor_msgs/msg/PacketMsg", "uint8[] buf\n", {}},
      {"std_msgs/msg/String", "string data\n", {}},
      {"std_msgs/msg/MultiArrayDimension", "string label\nuint32 size\nuint32 stride\n", {}},
      {"std_msgs/msg/MultiArrayLayout",
       "MultiArrayDimension[] dim\nuint32 data_offset\n",
       {"std_msgs/msg/MultiArrayDimension"}},
      {"std_msgs/msg/UInt8MultiArray",
       "MultiArrayLayout layout\nuint8[] data\n",
       {"std_msgs/msg/MultiArrayLayout"}},
      {"diagnostic_msgs/msg/KeyValue", "string key\nstring value\n", {}},
      {"diagnostic_msgs/msg/DiagnosticStatus",
       "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\n"
       "string message\nstring hardware_id\nKeyValue[] values\n",
       {"diagnostic_msgs/msg/KeyValue"}},
      {"diagnostic_msgs/msg/DiagnosticArray",
       "std_msgs/Header header\nDiagnosticStatus[] status\n",
       {"std_msgs/msg/Header", "diagnostic_msgs/msg/DiagnosticStatus"}},
  };
  return all;
}

const Definition* find_definition(std::string_view name) {
  const auto found = std::ranges::find(definitions(), name, &Definition::name);
  return found == definitions().end() ? nullptr : &*found;
}

// "sensor_msgs/msg/Imu" is "sensor_msgs/Imu" inside definitions.
std::string short_name(std::string_view name) {
  const size_t package = name.find('/');
  return std::string(name.substr(0, package)).append(name.substr(name.rfind('/')));
}

void add_contained(const Definition& definition, std::vector<std::string_view>& names) {
  for (const std::string_view name : definition.contains) {
    if (std::ranges::find(names, name) != names.end()) continue;
    names.push_back(name);
    add_contained(*find_definition(name), names);
  }
}

}  // namespace

std::optional<std::string> schema_of(std::string_view name) {
  const Definition* definition = find_definition(name);
  if (definition == nullptr) return std::nullopt;
  std::string text(definition->text);
  std::vector<std::string_view> names;
  add_contained(*definition, names);
  for (const std::string_view contained : names) {
    text.append(80, '=').append("\nMSG: ").append(short_name(contained)).append("\n");
    text += find_definition(contained)->text;
  }
  return text;
}

std::string normalise_type(std::string_view name) {
  std::vector<std::string_view> parts;
  while (!name.empty()) {
    const size_t end = std::min(name.find_first_of("/:"), name.size());
    const std::string_view part = name.substr(0, end);
    const bool of_dds = part == "dds_";
    if (!part.empty() && !of_dds && part != "msg") parts.push_back(part);
    name.remove_prefix(std::min(end + 1, name.size()));
    if (of_dds && name.ends_with('_')) name.remove_suffix(1);
  }
  if (parts.size() != 2) return {};
  if (parts[0] == "tf" && parts[1] == "tfMessage") parts = {"tf2_msgs", "TFMessage"};
  return std::string(parts[0]).append("/msg/").append(parts[1]);
}

}  // namespace infuse::ros
