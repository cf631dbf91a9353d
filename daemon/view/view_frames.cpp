#include "daemon/view/view_frames.hpp"

#include <bit>

#include "daemon/protocol/json.hpp"

namespace infuse::daemon {
namespace {

static_assert(std::endian::native == std::endian::little);
constexpr size_t kAlignment = 8;

Json matrix(const Eigen::Isometry3d& T) {
  Json out = Json::array();
  for (int i = 0; i < 16; ++i) out.push_back(T.matrix()(i / 4, i % 4));
  return out;
}

template <class Value>
void append(std::string& out, const std::vector<Value>& values) {
  out.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value));
}

std::string begin_frame(const Json& header, const ViewPoints& points, size_t more) {
  std::string text = json_text(header);
  const size_t unpadded = sizeof(uint32_t) + text.size();
  text.append((kAlignment - unpadded % kAlignment) % kAlignment, ' ');
  const auto length = static_cast<uint32_t>(text.size());
  std::string out;
  out.reserve(sizeof(length) + text.size() + kAlignment * points.size() + more);
  out.append(reinterpret_cast<const char*>(&length), sizeof(length));
  out += text;
  append(out, points.x);
  append(out, points.y);
  append(out, points.z);
  append(out, points.reflectivity);
  append(out, points.ring);
  return out;
}

}  // namespace

std::string encode_sweep(const ViewSweep& sweep, const Rig& rig) {
  const LidarMount& lidar = rig.lidars[sweep.lidar];
  Json header{{"kind", "sweep"},
              {"device", lidar.name},
              {"stamp", std::to_string(sweep.stamp.ns())},
              {"points", sweep.points.size()},
              {"deskewed", sweep.deskewed},
              {"T_vehicle_lidar", matrix(lidar.T_vehicle_lidar)}};
  if (sweep.T_odom_vehicle) header["T_odom_vehicle"] = matrix(*sweep.T_odom_vehicle);
  return begin_frame(header, sweep.points, 0);
}

std::string encode_image(const ViewImage& image, const std::vector<uint8_t>& jpeg, const Rig& rig) {
  const CameraMount& camera = rig.cameras[image.camera];
  const CameraIntrinsics& model = camera.intrinsics;
  const bool fisheye = model.model == CameraIntrinsics::Model::kFisheye;
  const Json header{{"kind", "image"},
                    {"device", camera.name},
                    {"stamp", std::to_string(image.frame.stamp.ns())},
                    {"width", image.frame.width},
                    {"height", image.frame.height},
                    {"points", image.points.size()},
                    {"model", fisheye ? "fisheye" : "pinhole"},
                    {"fx", model.fx},
                    {"fy", model.fy},
                    {"cx", model.cx},
                    {"cy", model.cy},
                    {"distortion", model.distortion},
                    {"T_camera_lidar", matrix(image.T_camera_lidar)},
                    {"T_camera_lidar_rig", matrix(camera.T_camera_lidar)}};
  std::string out = begin_frame(header, image.points, jpeg.size());
  append(out, jpeg);
  return out;
}

}  // namespace infuse::daemon
