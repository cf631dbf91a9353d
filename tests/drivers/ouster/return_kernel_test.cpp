// The kernel on random pixels: the same bytes by every instruction set, and the points of the
// published formula in double precision.

#include "drivers/ouster/return_kernel.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <random>

#include "drivers/ouster/packet.hpp"
#include "tests/drivers/ouster/made_metadata.hpp"
#include "tests/drivers/ouster/made_packet.hpp"

namespace infuse::ouster {
namespace {

/// A sensor that is mounted in its housing in no simple way.
Metadata tilted_sensor(Profile profile, size_t beams) {
  MadeMetadata values;
  values.beams = beams;
  values.profile = profile_info(profile).name;
  values.columns = "512";
  values.window = "[0, 511]";
  Metadata metadata = parse_metadata(made_metadata(values), "").value();
  metadata.T_lidar_beam.translation() = Eigen::Vector3d(0.027, 0, 0.004);
  metadata.T_sensor_lidar.linear() =
      Eigen::AngleAxisd(2.1, Eigen::Vector3d(0.2, -0.3, 1).normalized()).matrix();
  return metadata;
}

MadePixel random_pixel(std::mt19937& random, Profile profile) {
  const uint32_t unit = profile_info(profile).name.find("RNG15") != std::string_view::npos ? 8 : 1;
  const uint32_t bits = profile == Profile::kLegacy ? 20 : unit == 8 ? 15 : 19;
  const auto range = [&] {
    const auto value = static_cast<uint32_t>(random()) & ((uint32_t{1} << bits) - 1);
    return random() % 3 == 0 ? 0 : value * unit;
  };
  return {range(), range(), static_cast<uint8_t>(random()), static_cast<uint8_t>(random()), 0};
}

class OusterReturnKernel : public testing::TestWithParam<Profile> {};

TEST_P(OusterReturnKernel, GivesThePointsOfTheFormula) {
  for (const size_t beams : {8, 16, 32, 64, 128}) {
    const Metadata metadata = tilted_sensor(GetParam(), beams);
    std::mt19937 random(7);
    std::vector<std::vector<MadePixel>> pixels(512, std::vector<MadePixel>(beams));
    for (auto& column : pixels) {
      for (MadePixel& pixel : column) pixel = random_pixel(random, GetParam());
    }
    const auto payload =
        made_packet(metadata, {.first_measurement_id = 496,
                               .pixel = [&](uint16_t id, size_t b) { return pixels[id][b]; }});
    const auto packet = parse_packet(PacketLayout(metadata), payload);
    ASSERT_TRUE(packet);
    std::vector<ColumnPixels> columns;
    for (uint16_t i = 0; i < 16; ++i) {
      const Column& column = packet->columns[i];
      columns.push_back({column.pixels, column.measurement_id, static_cast<uint16_t>(100 + i), i});
    }
    const BeamTable table(metadata);
    std::array<Sweep, 3> sweeps;
    std::vector<Sweep*> made;
    for (const auto set :
         {InstructionSet::kBaseline, InstructionSet::kAvx2, InstructionSet::kAvx512}) {
      if (!supported(set)) continue;
      Sweep& sweep = sweeps[made.size()];
      sweep.resize(16 * beams * 2 + lidar::kReturnSlack);
      const lidar::ReturnArrays out{sweep.x.data(),
                                    sweep.y.data(),
                                    sweep.z.data(),
                                    sweep.range.data(),
                                    sweep.reflectivity.data(),
                                    sweep.ring.data(),
                                    sweep.column.data(),
                                    sweep.time_offset_ns.data(),
                                    sweep.return_kind.data()};
      sweep.resize(return_kernel(GetParam(), set)(table, columns, FirstReturn::kStrongest, out, 0));
      made.push_back(&sweep);
    }
    size_t n = 0;
    const Sweep& sweep = *made[0];
    const double zero = metadata.T_lidar_beam.translation().norm();
    for (uint16_t i = 0; i < 16; ++i) {
      const double encoder = 2 * std::numbers::pi * (1 - (496.0 + i) / 512);
      for (size_t beam = 0; beam < beams; ++beam) {
        const MadePixel& pixel = pixels[496u + i][beam];
        const double turned = encoder - metadata.azimuth[beam];
        const double phi = metadata.elevation[beam];
        const auto expect = [&](uint32_t millimetres, uint8_t reflectivity) {
          if (millimetres == 0) return;
          const double r = millimetres / 1000.0;
          const Eigen::Vector3d point =
              metadata.T_sensor_lidar *
              Eigen::Vector3d(
                  (r - zero) * std::cos(turned) * std::cos(phi) + 0.027 * std::cos(encoder),
                  (r - zero) * std::sin(turned) * std::cos(phi) + 0.027 * std::sin(encoder),
                  (r - zero) * std::sin(phi) + 0.004);
          ASSERT_LT(n, sweep.size());
          ASSERT_NEAR(sweep.x[n], point.x(), 1e-4 + r * 1e-7);
          ASSERT_NEAR(sweep.y[n], point.y(), 1e-4 + r * 1e-7);
          ASSERT_NEAR(sweep.z[n], point.z(), 1e-4 + r * 1e-7);
          ASSERT_FLOAT_EQ(sweep.range[n], static_cast<float>(r));
          ASSERT_FLOAT_EQ(sweep.reflectivity[n], static_cast<float>(reflectivity / 255.0));
          ASSERT_EQ(sweep.ring[n], beams - 1 - beam);
          ASSERT_EQ(sweep.column[n], 100 + i);
          ASSERT_EQ(sweep.time_offset_ns[n], i);
          ++n;
        };
        // Of eight beams the first returns come before the second ones: compared as sets below.
        if (profile_info(GetParam()).echoes == 1) expect(pixel.range, pixel.reflectivity);
      }
    }
    if (profile_info(GetParam()).echoes == 1) {
      ASSERT_EQ(n, sweep.size());
    }
    for (const Sweep* other : made) {
      ASSERT_EQ(other->size(), sweep.size());
      EXPECT_EQ(other->x, sweep.x);
      EXPECT_EQ(other->y, sweep.y);
      EXPECT_EQ(other->z, sweep.z);
      EXPECT_EQ(other->range, sweep.range);
      EXPECT_EQ(other->reflectivity, sweep.reflectivity);
      EXPECT_EQ(other->ring, sweep.ring);
      EXPECT_EQ(other->column, sweep.column);
      EXPECT_EQ(other->time_offset_ns, sweep.time_offset_ns);
      EXPECT_EQ(other->return_kind, sweep.return_kind);
    }
  }
}

/// With the profiles of two returns.
class OusterTwoReturns : public testing::TestWithParam<Profile> {};

TEST_P(OusterTwoReturns, HaveTheirKinds) {
  using enum ReturnKind;
  struct Case {
    uint32_t range, range2;
    FirstReturn order;
    std::vector<ReturnKind> kinds;
  };
  const std::vector<Case> cases{
      {8000, 16'000, FirstReturn::kStrongest, {kStrongest, kLast}},
      {16'000, 8000, FirstReturn::kStrongest, {kBoth, kSecondStrongest}},
      {8000, 0, FirstReturn::kStrongest, {kBoth}},
      {16'000, 8000, FirstReturn::kFarthest, {kLast, kFirst}},
      {8000, 16'000, FirstReturn::kNearest, {kFirst, kSecond}},
      {0, 0, FirstReturn::kStrongest, {}},
  };
  const Metadata metadata = tilted_sensor(GetParam(), 8);
  const BeamTable table(metadata);
  for (const Case& test : cases) {
    const auto payload =
        made_packet(metadata, {.pixel = [&](uint16_t, size_t beam) {
                      return beam == 3 ? MadePixel{test.range, test.range2, 1, 2, 0} : MadePixel{};
                    }});
    const auto packet = parse_packet(PacketLayout(metadata), payload);
    const ColumnPixels column{packet->columns[0].pixels, 0, 0, 0};
    Sweep sweep;
    sweep.resize(2 * lidar::kReturnSlack);
    const lidar::ReturnArrays out{sweep.x.data(),
                                  sweep.y.data(),
                                  sweep.z.data(),
                                  sweep.range.data(),
                                  sweep.reflectivity.data(),
                                  sweep.ring.data(),
                                  sweep.column.data(),
                                  sweep.time_offset_ns.data(),
                                  sweep.return_kind.data()};
    sweep.resize(return_kernel(GetParam(), InstructionSet::kBaseline)(table, std::span(&column, 1),
                                                                      test.order, out, 0));
    EXPECT_EQ(std::vector<ReturnKind>(sweep.return_kind.begin(), sweep.return_kind.end()),
              test.kinds);
    if (sweep.size() == 2) {
      EXPECT_FLOAT_EQ(sweep.range[1], static_cast<float>(test.range2) / 1000);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Profiles, OusterReturnKernel,
                         testing::Values(Profile::kLegacy, Profile::kRng19, Profile::kRng19Dual,
                                         Profile::kRng15, Profile::kFusaDual, Profile::kRng15Dual,
                                         Profile::kRng15Zone, Profile::kRng15Window,
                                         Profile::kRng19Zone, Profile::kRng19ZoneDual));
INSTANTIATE_TEST_SUITE_P(Profiles, OusterTwoReturns,
                         testing::Values(Profile::kRng19Dual, Profile::kFusaDual));

TEST(OusterBeamTable, CountsRingsFromBelowAndLeavesOutBeamsThatDoNotExist) {
  // 16 of 64, as firmware 1.13 wrote them.
  std::string elevation, azimuth;
  for (int beam = 0; beam < 64; ++beam) {
    const std::string comma = beam == 0 ? "" : ",";
    elevation += comma + (beam % 4 == 3 ? std::to_string(15 - beam / 2.0) : "0");
    azimuth += comma + (beam % 4 == 3 ? "-3.2" : "0");
  }
  const Metadata metadata =
      parse_metadata(R"({"lidar_mode": "512x10", "beam_altitude_angles": [)" + elevation +
                         R"(], "beam_azimuth_angles": [)" + azimuth + "]}",
                     "")
          .value();
  const BeamTable table(metadata);
  EXPECT_EQ(table.rings, 16);
  EXPECT_EQ(table.beams, 64);
  for (size_t beam = 3; beam < 64; beam += 4) {
    EXPECT_EQ(table.ring[beam], static_cast<int>(15 - beam / 4));
  }
}

}  // namespace
}  // namespace infuse::ouster
