#pragma once

#include <cstring>
#include <string>

#include "daemon/pipeline/view_tap.hpp"
#include "daemon/protocol/json.hpp"
#include "drivers/measurement/rig.hpp"

namespace infuse::daemon {

/// A lidar and a camera.
inline Rig small_rig() {
  Rig out;
  LidarMount lidar{.name = "top"};
  lidar.T_vehicle_lidar.translation() = Eigen::Vector3d(0.5, 0, 1.8);
  out.lidars = {lidar};
  CameraMount camera{.name = "front", .lidar = "top"};
  camera.intrinsics = {.width = 4, .height = 2, .fx = 3, .fy = 3, .cx = 2, .cy = 1};
  out.cameras = {camera};
  return out;
}

/// A sweep of `count` returns at (i, −i, 1) cm · 10.
struct SmallSweep {
  explicit SmallSweep(size_t count) {
    sweep.resize(count);
    at.x.resize(count);
    at.y.resize(count);
    at.z.resize(count);
    for (size_t i = 0; i < count; ++i) {
      at.x[i] = 0.1F * static_cast<float>(i);
      at.y[i] = -0.1F * static_cast<float>(i);
      at.z[i] = 0.1F;
      sweep.reflectivity[i] = i % 2 == 0 ? 0.0F : 1.0F;
      sweep.ring[i] = static_cast<uint16_t>(i);
    }
    at.reference = Stamp::from_ns(1'700'000'000'123'456'789);
  }
  SweepSnapshot snapshot() const { return {LidarIndex(0), sweep, at}; }
  Sweep sweep;
  motion::DeskewedSweep at;
};

/// A binary message, read as the page does.
struct Frame {
  explicit Frame(const std::string& data) : bytes(data) {
    uint32_t length = 0;
    std::memcpy(&length, bytes.data(), 4);
    header = Json::parse(bytes.substr(4, length));
    payload = 4 + length;
  }
  int16_t coordinate(size_t axis, size_t i) const {
    int16_t value = 0;
    std::memcpy(&value, bytes.data() + payload + 2 * (axis * points() + i), 2);
    return value;
  }
  uint8_t reflectivity(size_t i) const {
    return static_cast<uint8_t>(bytes[payload + 6 * points() + i]);
  }
  size_t points() const { return header["points"].get<size_t>(); }
  std::string bytes;
  Json header;
  size_t payload = 0;
};

}  // namespace infuse::daemon
