#include "drivers/ros/sweep_cloud.hpp"

#include <cstring>

namespace infuse::ros {
namespace {

constexpr uint32_t kPointStep = 28;

template <class Values>
void fill(const Values& values, size_t offset, std::vector<uint8_t>& data) {
  for (size_t i = 0; i < values.size(); ++i)
    std::memcpy(data.data() + i * kPointStep + offset, &values[i], sizeof values[i]);
}

}  // namespace

PointCloud2 to_cloud(const Sweep& sweep, const std::string& frame, std::vector<uint8_t>& data) {
  PointCloud2 cloud;
  cloud.header.stamp = Time::from(sweep.stamp);
  cloud.header.frame_id = frame;
  cloud.height = 1;
  cloud.width = static_cast<uint32_t>(sweep.size());
  cloud.point_step = kPointStep;
  cloud.row_step = kPointStep * cloud.width;
  cloud.is_dense = true;
  cloud.point_fields = {{"x", 0, PointField::kFloat32, 1},
                        {"y", 4, PointField::kFloat32, 1},
                        {"z", 8, PointField::kFloat32, 1},
                        {"intensity", 12, PointField::kFloat32, 1}};
  data.assign(sweep.size() * kPointStep, 0);
  fill(sweep.x, 0, data);
  fill(sweep.y, 4, data);
  fill(sweep.z, 8, data);
  fill(sweep.reflectivity, 12, data);
  if (sweep.has_times) {
    cloud.point_fields.push_back({"t", 16, PointField::kUint32, 1});
    fill(sweep.time_offset_ns, 16, data);
  }
  cloud.point_fields.push_back({"ring", 20, PointField::kUint16, 1});
  cloud.point_fields.push_back({"column", 22, PointField::kUint16, 1});
  cloud.point_fields.push_back({"return_kind", 24, PointField::kUint8, 1});
  fill(sweep.ring, 20, data);
  fill(sweep.column, 22, data);
  fill(sweep.return_kind, 24, data);
  cloud.data = data;
  return cloud;
}

}  // namespace infuse::ros
