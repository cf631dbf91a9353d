#include "daemon/view/view_frames.hpp"

#include <bit>
#include <cmath>

#include "drivers/measurement/angles.hpp"

namespace infuse::daemon {
namespace {

static_assert(std::endian::native == std::endian::little);
constexpr size_t kAlignment = 8;
constexpr int kMapCells = 512;    // along an edge of the part that is sent
constexpr double kMapCell = 0.5;  // m

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

std::string encode_frame(const Json& header) { return begin_frame(header, {}, 0); }

std::string encode_sweep(const ViewSweep& sweep, const Rig& rig) {
  const LidarMount& lidar = rig.lidars[sweep.lidar];
  Json header{{"kind", "sweep"},
              {"device", lidar.name},
              {"stamp", std::to_string(sweep.stamp.ns())},
              {"points", sweep.points.size()},
              {"deskewed", sweep.deskewed},
              {"T_vehicle_lidar", matrix(lidar.T_vehicle_lidar)}};
  if (sweep.T_odom_vehicle) header["T_odom_vehicle"] = matrix(*sweep.T_odom_vehicle);
  if (sweep.map) {
    const Eigen::Matrix2d& covariance = sweep.map->covariance;
    header["T_map_vehicle"] = matrix(sweep.map->T_map_vehicle);
    header["covariance_map"] = {covariance(0, 0), covariance(0, 1), covariance(1, 1)};
    Json& particles = header["particles"] = Json::array();
    for (const Eigen::Vector2f& at : sweep.map->particles) {
      particles.push_back(std::round(10 * static_cast<double>(at.x())) / 10);
      particles.push_back(std::round(10 * static_cast<double>(at.y())) / 10);
    }
  }
  return begin_frame(header, sweep.points, 0);
}

std::string encode_image(const ViewImage& image, const std::vector<uint8_t>& jpeg, const Rig& rig) {
  const CameraMount& camera = rig.cameras[image.camera];
  const CameraIntrinsics& model = camera.intrinsics;
  const bool fisheye = model.model == CameraIntrinsics::Model::kFisheye;
  const LidarMount* lidar = rig.find_lidar(camera.lidar);
  const Eigen::Isometry3d T_vehicle_lidar =
      lidar != nullptr ? lidar->T_vehicle_lidar : Eigen::Isometry3d::Identity();
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
                    {"T_vehicle_lidar", matrix(T_vehicle_lidar)},
                    {"T_camera_lidar", matrix(image.T_camera_lidar)},
                    {"T_camera_lidar_rig", matrix(camera.T_camera_lidar)}};
  std::string out = begin_frame(header, image.points, jpeg.size());
  append(out, jpeg);
  return out;
}

std::string encode_map(const streetmap::SegmentMap& map, const Eigen::Vector2d& middle,
                       Stamp stamp) {
  const Eigen::Vector2d corner = middle.array() - kMapCells / 2 * kMapCell;
  Json header{{"kind", "map"},        {"stamp", std::to_string(stamp.ns())},
              {"points", 0},          {"cell", kMapCell},
              {"columns", kMapCells}, {"rows", kMapCells},
              {"x", corner.x()},      {"y", corner.y()}};
  if (map.frame().georeferenced) {
    header["origin_deg"] = {map.frame().latitude / kDegree, map.frame().longitude / kDegree};
  }
  std::string out = begin_frame(header, {}, kMapCells * kMapCells);
  for (int row = 0; row < kMapCells; ++row) {
    for (int column = 0; column < kMapCells; ++column) {
      const uint32_t id =
          map.id_at(corner.x() + (column + 0.5) * kMapCell, corner.y() + (row + 0.5) * kMapCell);
      out.push_back(static_cast<char>(map.segment(id).kind));
    }
  }
  return out;
}

}  // namespace infuse::daemon
