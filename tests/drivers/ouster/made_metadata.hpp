#pragma once

#include <cmath>
#include <string>

namespace infuse::ouster {

/// Values of a made metadata file; those that are text stand in the file as they are.
struct MadeMetadata {
  bool nested = true;  ///< the layout of firmware from 3.0 on
  std::string product_line = "OS-1-64";
  size_t beams = 64;
  std::string profile = "RNG19_RFL8_SIG16_NIR16";
  std::string columns = "1024";
  std::string columns_per_packet = "16";
  std::string window = "[0, 1023]";
  std::string mode = "1024x10";
  std::string lidar_to_sensor = "[-1,0,0,0, 0,-1,0,0, 0,0,1,36.18, 0,0,0,1]";
  std::string first_elevation = "21.5";
  std::string extra_config{};  ///< of config_params, with a leading comma
};

/// Elevation of a made sensor's beam, °: from above, a step of 0.7°.
inline double made_elevation(size_t beam) { return 21.5 - 0.7 * static_cast<double>(beam); }

/// Azimuth offset of a made sensor's beam, °: four columns of lasers.
inline double made_azimuth(size_t beam) {
  return 3.0 - 1.5 * static_cast<double>(beam % 4 * 3 % 5);
}

/// A metadata file.
inline std::string made_metadata(const MadeMetadata& values) {
  std::string elevation, azimuth;
  for (size_t i = 0; i < values.beams; ++i) {
    const std::string comma = i == 0 ? "" : ", ";
    elevation += comma + (i == 0 ? values.first_elevation : std::to_string(made_elevation(i)));
    azimuth += comma + std::to_string(made_azimuth(i));
  }
  const std::string info = R"("prod_line": ")" + values.product_line +
                           R"(", "prod_sn": "992110000123", "build_rev": "v2.3.0")";
  const std::string beams = R"("beam_altitude_angles": [)" + elevation +
                            R"(], "beam_azimuth_angles": [)" + azimuth +
                            R"(], "lidar_origin_to_beam_origin_mm": 15.806)";
  const std::string lidar = R"("lidar_to_sensor_transform": )" + values.lidar_to_sensor;
  const std::string imu =
      R"("imu_to_sensor_transform": [1,0,0,6.253, 0,1,0,-11.775, 0,0,1,7.645, 0,0,0,1])";
  const std::string config = R"("lidar_mode": ")" + values.mode +
                             R"(", "udp_port_lidar": 7502, "udp_port_imu": 7503)" +
                             values.extra_config;
  const std::string format = R"({"pixels_per_column": )" + std::to_string(values.beams) +
                             R"(, "columns_per_packet": )" + values.columns_per_packet +
                             R"(, "columns_per_frame": )" + values.columns +
                             R"(, "column_window": )" + values.window +
                             R"(, "udp_profile_lidar": ")" + values.profile + "\"}";
  if (!values.nested) {
    return "{" + info + ", " + beams + ", " + lidar + ", " + imu + ", " + config +
           R"(, "data_format": )" + format + "}";
  }
  return R"({"sensor_info": {)" + info + R"(}, "beam_intrinsics": {)" + beams +
         R"(}, "lidar_intrinsics": {)" + lidar + R"(}, "imu_intrinsics": {)" + imu +
         R"(}, "config_params": {)" + config + R"(}, "lidar_data_format": )" + format + "}";
}

}  // namespace infuse::ouster
