#pragma once

#include <gmock/gmock.h>

namespace infuse::recording {

inline const char* const kIdentity = "[1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1]";

inline const char* const kDrive = R"(name = "around the block"
times = "recorded"

[[lidar]]
name = "top"
model = "HDL-32E"
packets = "lidar.pcap"
port = 2368
sender = "192.168.1.201"
T_vehicle_lidar = [
  0, -1, 0, 0.5,
  1,  0, 0, -0.25,
  0,  0, 1, 1.75,
  0,  0, 0, 1,
]

[[lidar]]
name = "rear"
sweeps = "rear"
calibration = "rear.xml"
T_vehicle_lidar = [1, 0, 0, -1,  0, 1, 0, 0,  0, 0, 1, 1,  0, 0, 0, 1]

[[camera]]
name = "left"
images = "left"
model = "fisheye"
width = 1242
height = 375
fx = 721.5
fy = 721
cx = 609.5593
cy = 172.854
distortion = [0.1, -0.02, 3e-3, 0]
lidar = "top"
T_camera_lidar = [0, -1, 0, 0.06,  0, 0, -1, 0,  1, 0, 0, -0.27,  0, 0, 0, 1]
stamp_delay_ms = 12.5
readout_ms = 20
mosaic = "gbrg"
grey = true

[can]
log = "can.log"
dbc = "vehicle.dbc"
interface = "can0"
reverse_gear = 1

[can.signals]
yaw_rate = "KINEMATICS.YAW_RATE"
wheel_speed_front_left = { signal = "WHEELS.FL", scale = -1, unit = "km/h" }

[imu]
file = "imu.csv"
delay_ms = 57

[gnss]
file = "gnss.csv"

[map]
file = "map.osm"

[truth]
poses = "truth/poses.tum"
rig = "truth/rig.toml"
)";

}  // namespace infuse::recording
