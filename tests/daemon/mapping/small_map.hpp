#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "daemon/mapping/g2o_file.hpp"
#include "daemon/mapping/place_map.hpp"
#include "drivers/text/checksum.hpp"
#include "tests/daemon/mapping/cloud_of.hpp"
#include "tests/stamp_at.hpp"

namespace infuse::daemon {

/// Writes a complete map of keyframes along x, `spacing` m apart: a few points each. All keep their
/// clouds, or those of `kept`.
inline void write_small_map(const std::filesystem::path& path, size_t count, double spacing,
                            const std::vector<size_t>& kept = {}) {
  const MapFolder folder(path);
  ASSERT_TRUE(folder.create());
  std::vector<MapKeyframe> keyframes;
  G2oGraph<3> graph;
  graph.graph.poses.push_back(Eigen::Isometry3d::Identity());  // the map's origin
  graph.ids.push_back(0);
  for (size_t k = 0; k < count; ++k) {
    MapKeyframe keyframe;
    keyframe.keyframe.stamp = infuse::at(static_cast<double>(k) + 1);
    keyframe.keyframe.distance_driven = spacing * static_cast<double>(k);
    keyframe.keyframe.T_odom_vehicle.translation().x() = keyframe.keyframe.distance_driven;
    const auto checksum = folder.write_cloud(
        k, cloud_of({{1, 2, 0, 0.5F}, {static_cast<float>(spacing), 3, 1, 0.25F}}));
    ASSERT_TRUE(checksum);
    keyframe.points = 2;
    keyframe.cloud_checksum = *checksum;
    keyframes.push_back(keyframe);
    graph.graph.poses.push_back(keyframe.keyframe.T_odom_vehicle);
    graph.ids.push_back(static_cast<int64_t>(k) + 1);
  }
  MapJson drive = make_manifest();
  drive["T_vehicle_lidar"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  ASSERT_TRUE(write_drive(folder, drive, keyframes, {},
                          std::vector<places::PlaceDescriptor>(keyframes.size())));
  MapJson map = make_manifest();
  if (!kept.empty()) {
    map[kKeptClouds] = kept;
    folder.keep_clouds(kept);
  }
  const std::string graph_text = format_g2o(graph);
  ASSERT_TRUE(folder.write(map_file::kGraph, graph_text));
  map["files"][map_file::kGraph] = text::checksum(graph_text);
  map["files"][map_file::kDrive] = text::checksum(folder.read(map_file::kDrive).value());
  ASSERT_TRUE(folder.write(map_file::kMap, map.dump()));
}

}  // namespace infuse::daemon
