#include "drivers/ouster/beam_table.hpp"

#include <cmath>
#include <numbers>

namespace infuse::ouster {
BeamTable::BeamTable(const Metadata& metadata)
    : beams(static_cast<uint16_t>(metadata.beams())),
      beam_radius(static_cast<float>(metadata.T_lidar_beam.translation().norm())) {
  const std::vector<size_t> order = metadata.beams_from_below();
  rings = static_cast<uint16_t>(order.size());
  for (size_t i = 0; i < order.size(); ++i) ring[order[i]] = static_cast<int32_t>(i);

  const size_t columns = metadata.columns_per_turn;
  for (auto* field : {&direction_x, &direction_y, &direction_z}) field->resize(columns * beams);
  for (auto* field : {&origin_x, &origin_y, &origin_z}) field->resize(columns);
  // A direction is linear in the encoder's cosine and sine, and so is an origin.
  using Directions = Eigen::Matrix3Xd;
  const Eigen::Matrix3d rotation = metadata.T_sensor_lidar.linear();
  Directions of_cos(3, beams), of_sin(3, beams), constant(3, beams);
  for (int beam = 0; beam < beams; ++beam) {
    const double azimuth = metadata.azimuth[static_cast<size_t>(beam)];
    const double elevation = metadata.elevation[static_cast<size_t>(beam)];
    const Eigen::Vector3d level(std::cos(azimuth), -std::sin(azimuth), 0);
    of_cos.col(beam) = rotation * level * std::cos(elevation);
    of_sin.col(beam) = rotation * Eigen::Vector3d(-level.y(), level.x(), 0) * std::cos(elevation);
    constant.col(beam) = rotation * Eigen::Vector3d(0, 0, std::sin(elevation));
  }
  const Eigen::Vector3d beam_origin = metadata.T_lidar_beam.translation();
  Directions directions(3, beams);
  for (size_t column = 0; column < columns; ++column) {
    const double encoder =
        2 * std::numbers::pi * (1 - static_cast<double>(column) / static_cast<double>(columns));
    const double cos = std::cos(encoder), sin = std::sin(encoder);
    const Eigen::Vector3d origin =
        metadata.T_sensor_lidar *
        Eigen::Vector3d(beam_origin.x() * cos, beam_origin.x() * sin, beam_origin.z());
    origin_x[column] = static_cast<float>(origin.x());
    origin_y[column] = static_cast<float>(origin.y());
    origin_z[column] = static_cast<float>(origin.z());
    directions = of_cos * cos + of_sin * sin + constant;
    for (int beam = 0; beam < beams; ++beam) {
      const size_t i = column * beams + static_cast<size_t>(beam);
      direction_x[i] = static_cast<float>(directions(0, beam));
      direction_y[i] = static_cast<float>(directions(1, beam));
      direction_z[i] = static_cast<float>(directions(2, beam));
    }
  }
}

}  // namespace infuse::ouster
