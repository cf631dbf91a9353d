// The vertical offset of each beam: the manuals' numbers, and the height of each ring above the
// ground plane of real captures with and without them.

#include "drivers/velodyne/beam_origins.hpp"
#include "drivers/velodyne/decoder.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cstdio>
#include <random>

#include "drivers/measurement/angles.hpp"
#include "tests/drivers/lidar/assemble.hpp"
#include "tests/drivers/velodyne/share.hpp"
#include "tests/pcap_packets.hpp"
#include "tests/real_data.hpp"

namespace infuse::velodyne {
namespace {

double offset_mm(Model model, size_t laser) {
  return 1e3 * built_in_calibration(model).beams[laser].vertical_offset;
}

// VLP-16 user manual 63-9243, table of vertical corrections by laser.
TEST(BeamOrigins, AreThoseOfTheVlp16Manual) {
  const std::array<double, 16> manual{11.2, -0.7, 9.7, -2.2, 8.1, -3.7, 6.6, -5.1,
                                      5.1,  -6.6, 3.7, -8.1, 2.2, -9.7, 0.7, -11.2};
  for (size_t laser = 0; laser < 16; ++laser) {
    EXPECT_NEAR(offset_mm(Model::kVlp16, laser), manual[laser], 0.06) << laser;
  }
}

TEST(BeamOrigins, SpanTheRangesOfTheOtherManuals) {
  EXPECT_NEAR(offset_mm(Model::kHdl32e, 0), 17.2, 0.05);   // −30.67°
  EXPECT_NEAR(offset_mm(Model::kHdl32e, 31), -5.5, 0.05);  // 10.67°
  EXPECT_NEAR(offset_mm(Model::kVlp32c, 0), 19.8, 0.05);   // −25°
  EXPECT_NEAR(offset_mm(Model::kVls128, 36), 27.3, 0.05);  // −25°
  for (const ModelInfo& info : models()) {
    const Calibration single = single_origin_calibration(info.model);
    const Calibration& standard = built_in_calibration(info.model);
    for (size_t laser = 0; laser < info.lasers; ++laser) {
      EXPECT_EQ(single.beams[laser].elevation, standard.beams[laser].elevation);
      EXPECT_EQ(single.beams[laser].vertical_offset,
                info.calibrated_per_unit ? standard.beams[laser].vertical_offset : 0);
    }
  }
}

struct Point {
  Eigen::Vector3d position;
  size_t ring;
};

/// Returns of a capture within 25 m, below the sensor.
std::vector<Point> low_points(const std::filesystem::path& path, Model model,
                              const Calibration& calibration) {
  std::vector<CapturedDatagram> packets = read_capture(path);
  std::erase_if(packets, [](const auto& p) { return p.payload.size() != kPacketSize; });
  Decoder decoder({.model = &lidar_model(model), .calibration = share(model, calibration)});
  std::vector<Point> points;
  for (const Sweep& sweep : assemble(decoder, packets)) {
    for (size_t i = 0; i < sweep.size(); ++i) {
      const Eigen::Vector3d at(sweep.x[i], sweep.y[i], sweep.z[i]);
      if (at.z() < -0.3 && at.head<2>().norm() < 25) points.push_back({at, sweep.ring[i]});
    }
  }
  return points;
}

struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 0;

  double height(const Eigen::Vector3d& at) const { return normal.dot(at) - offset; }
};

/// The plane of most points by random samples, then refined with equal weight for every ring.
Plane fit_ground(const std::vector<Point>& points) {
  std::mt19937 random(1);
  const auto pick = [&]() -> const Eigen::Vector3d& {
    return points[random() % points.size()].position;
  };
  Plane best;
  size_t most = 0;
  for (int sample = 0; sample < 400; ++sample) {
    const Eigen::Vector3d a = pick();
    Plane plane;
    plane.normal = (pick() - a).cross(pick() - a).normalized();
    if (plane.normal.z() < 0) plane.normal = -plane.normal;
    if (!(plane.normal.z() > 0.97)) continue;
    plane.offset = plane.normal.dot(a);
    size_t near = 0;
    for (size_t i = 0; i < points.size(); i += points.size() / 3000 + 1) {
      near += std::abs(plane.height(points[i].position)) < 0.05;
    }
    if (near > most) {
      most = near;
      best = plane;
    }
  }
  for (int iteration = 0; iteration < 10; ++iteration) {
    std::array<double, 64> count{};
    const auto used = [&](const Point& p) { return std::abs(best.height(p.position)) < 0.1; };
    for (const Point& p : points) count[p.ring] += used(p);
    double total = 0;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
    for (const Point& p : points) {
      if (!used(p) || count[p.ring] < 300) continue;
      const double weight = 1 / count[p.ring];
      total += weight;
      mean += weight * p.position;
      square += weight * p.position * p.position.transpose();
    }
    mean /= total;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(square / total -
                                                                mean * mean.transpose());
    best.normal = solver.eigenvectors().col(0);
    if (best.normal.z() < 0) best.normal = -best.normal;
    best.offset = best.normal.dot(mean);
  }
  return best;
}

struct RingHeight {
  double count = 0, range = 0, height = 0;  ///< range and height: means, m
};

std::array<RingHeight, 64> ring_heights(const std::vector<Point>& points) {
  const Plane plane = fit_ground(points);
  std::array<RingHeight, 64> rings{};
  for (const Point& p : points) {
    const double height = plane.height(p.position);
    if (std::abs(height) > 0.1) continue;
    RingHeight& ring = rings[p.ring];
    ++ring.count;
    ring.range += p.position.head<2>().norm();
    ring.height += height;
  }
  for (RingHeight& ring : rings) {
    ring.range /= ring.count;
    ring.height /= ring.count;
  }
  return rings;
}

/// Rms height of the rings above the ground, m.
double rms_height(const std::array<RingHeight, 64>& rings) {
  double squares = 0;
  double count = 0;
  for (const RingHeight& ring : rings) {
    if (ring.count < 300) continue;
    squares += ring.height * ring.height;
    ++count;
  }
  return std::sqrt(squares / count);
}

/// Prints the table of drivers/velodyne/accuracy.md; returns the rms heights without and with.
std::array<double, 2> compare(const char* file, Model model) {
  const std::filesystem::path path = real_data(std::string("velodyne/") + file);
  const auto points = low_points(path, model, single_origin_calibration(model));
  EXPECT_GT(points.size(), 1000U) << file;
  if (points.empty()) return {};
  const auto without = ring_heights(points);
  const auto with = ring_heights(low_points(path, model, built_in_calibration(model)));
  std::printf("%s\n", file);
  for (size_t ring = 0; ring < without.size(); ++ring) {
    if (without[ring].count < 300 || with[ring].count < 300) continue;
    std::printf("| %zu | %.1f | %.0f | %+.1f | %+.1f |\n", ring, without[ring].range,
                without[ring].count, 1e3 * without[ring].height, 1e3 * with[ring].height);
  }
  const std::array<double, 2> rms{rms_height(without), rms_height(with)};
  std::printf("rms of the rings: %.1f mm without, %.1f mm with\n", 1e3 * rms[0], 1e3 * rms[1]);
  return rms;
}

// Offsets of the right sign flatten the ground; their size cannot be seen on it, since it is not
// flat to millimetres.
TEST(RealBeamOrigins, OffsetsOfTheRightSignFlattenTheGround) {
  INFUSE_REAL_DATA_OR_SKIP(path, "velodyne/hdl32e-monterey.pcap");
  const ModelInfo& info = model_info(Model::kHdl32e);
  const auto points = low_points(path, info.model, single_origin_calibration(info.model));
  std::array<double, kMaxSlots> tangent{};
  const auto rings = built_in_calibration(info.model).rings(info);
  for (size_t laser = 0; laser < info.lasers; ++laser) {
    tangent[rings[laser]] = std::tan(built_in_calibration(info.model).beams[laser].elevation);
  }
  double before = 1;
  for (int mm = -30; mm <= 90; mm += 30) {
    std::vector<Point> raised = points;
    for (Point& p : raised) p.position.z() -= 1e-3 * mm * tangent[p.ring];
    const double rms = rms_height(ring_heights(raised));
    std::printf("| %d | %.1f |\n", mm, 1e3 * rms);
    EXPECT_LT(rms, before);
    before = rms;
  }
}

TEST(RealBeamOrigins, RingsAboveTheGroundPlane) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "velodyne");
  for (const auto& [file, model] :
       std::vector<std::pair<const char*, Model>>{{"hdl32e-monterey.pcap", Model::kHdl32e},
                                                  {"vlp16-gps.pcap", Model::kVlp16},
                                                  {"vlp16-dual-return.pcap", Model::kVlp16}}) {
    const auto [without, with] = compare(file, model);
    EXPECT_LT(with, without) << file;
  }
}

}  // namespace
}  // namespace infuse::velodyne
