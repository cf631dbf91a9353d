#include "drivers/recording/pcd_sweep.hpp"
#include "drivers/measurement/angles.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <set>

#include "drivers/recording/sweep_export.hpp"
#include "drivers/recording/sweep_files.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::recording {
namespace {

using ::testing::HasSubstr;

template <class Value>
std::string to_bytes(Value value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

std::string make_header(const std::string& fields, size_t points, const std::string& data) {
  return "# .PCD v0.7\nVERSION 0.7\n" + fields + "WIDTH " + std::to_string(points) +
         "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + std::to_string(points) + "\nDATA " +
         data + "\n";
}

constexpr const char* kXyziFields =
    "FIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n";

// The error for a file of these bytes, or an empty string.
std::string parse_error(const std::string& bytes) {
  Sweep sweep;
  const auto parsed = parse_pcd_sweep(bytes, sweep);
  return parsed ? "" : parsed.error().message();
}

// Compresses without back references: literal runs of at most 32 bytes.
std::string compress(const std::string& bytes) {
  std::string out;
  for (size_t at = 0; at < bytes.size(); at += 32) {
    const std::string run = bytes.substr(at, 32);
    out += static_cast<char>(run.size() - 1) + run;
  }
  return to_bytes(static_cast<uint32_t>(out.size())) +
         to_bytes(static_cast<uint32_t>(bytes.size())) + out;
}

// Returns of four beams in firing order (clockwise, all beams at once). Beams are numbered as
// wired.
struct SyntheticReturn {
  double x, y, z;
  int ring_number;  // in the file
  int from_below;   // by elevation
  int intensity;    // 0 … 255
};
std::vector<SyntheticReturn> make_returns() {
  constexpr std::array<int, 4> kFromBelow = {2, 0, 3, 1};
  std::vector<SyntheticReturn> all;
  for (int step = 0; step < 360; ++step) {
    const double azimuth = -(step + 0.25) * kDegree;
    for (int wire = 0; wire < 4; ++wire) {
      if ((step + 3 * wire) % 7 == 0) continue;
      const int from_below = kFromBelow[static_cast<size_t>(wire)];
      const double elevation = (from_below - 2) * 0.05;
      const double range = 4 + step % 11;
      all.push_back({range * std::cos(elevation) * std::cos(azimuth),
                     range * std::cos(elevation) * std::sin(azimuth), range * std::sin(elevation),
                     wire, from_below, (step * 5 + wire) % 256});
    }
  }
  return all;
}

void expect_synthetic_returns(const Sweep& sweep) {
  const std::vector<SyntheticReturn> made = make_returns();
  ASSERT_EQ(sweep.size(), made.size());
  EXPECT_EQ(sweep.rings, 4);
  EXPECT_EQ(sweep.columns, 360U);
  EXPECT_FALSE(sweep.has_times);
  std::set<size_t> found;
  for (const SyntheticReturn& one : made) {
    for (size_t i = 0; i < sweep.size(); ++i) {
      if (std::abs(sweep.x[i] - one.x) > 1e-5 || std::abs(sweep.y[i] - one.y) > 1e-5) continue;
      if (std::abs(sweep.z[i] - one.z) > 1e-5) continue;
      found.insert(i);
      EXPECT_EQ(sweep.ring[i], one.from_below);
      EXPECT_NEAR(sweep.range[i], std::hypot(one.x, one.y, one.z), 1e-5);
      EXPECT_NEAR(sweep.reflectivity[i], one.intensity / 255.0, 1e-6);
      const double azimuth = std::atan2(one.y, one.x);
      EXPECT_EQ(sweep.column[i],
                static_cast<int>((azimuth < 0 ? azimuth + 2 * M_PI : azimuth) / kDegree));
    }
  }
  EXPECT_EQ(found.size(), made.size());
}

constexpr const char* kXyziRingFields =
    "FIELDS x y z intensity ring timestamp\nSIZE 4 4 4 1 2 8\nTYPE F F F U U F\n"
    "COUNT 1 1 1 1 1 1\n";

TEST(PcdTimes, ExportedSweepIsReadBackAsItWas) {
  const ScratchFolder folder;
  std::mt19937 random(5);
  Sweep sweep;
  sweep.resize(200);
  for (size_t i = 0; i < sweep.size(); ++i) {
    sweep.x[i] = static_cast<float>(i % 17) - 8.5f;
    sweep.y[i] = static_cast<float>(i % 13) - 6.5f;
    sweep.z[i] = 0.5f;
    sweep.range[i] =
        std::sqrt(sweep.x[i] * sweep.x[i] + sweep.y[i] * sweep.y[i] + sweep.z[i] * sweep.z[i]);
    sweep.reflectivity[i] = static_cast<float>(random() % 100) / 100;
    sweep.ring[i] = static_cast<uint16_t>(random() % 32);
    sweep.column[i] = static_cast<uint16_t>(random() % 1000);
    sweep.time_offset_ns[i] = static_cast<int32_t>(random() % 100'000'000);
    sweep.return_kind[i] = static_cast<ReturnKind>(random() % 3);
  }
  ASSERT_TRUE(export_sweep(sweep, folder / "a.pcd", SweepFormat::kPcd));
  Sweep read;
  ASSERT_TRUE(read_sweep_file(folder / "a.pcd", read));
  EXPECT_TRUE(read.has_times);
  EXPECT_TRUE(read.x == sweep.x && read.y == sweep.y && read.range == sweep.range);
  EXPECT_TRUE(read.reflectivity == sweep.reflectivity);
  EXPECT_TRUE(read.ring == sweep.ring && read.column == sweep.column);
  EXPECT_TRUE(read.time_offset_ns == sweep.time_offset_ns);
  EXPECT_TRUE(read.return_kind == sweep.return_kind);
  sweep.has_times = false;  // then no file states any
  ASSERT_TRUE(export_sweep(sweep, folder / "a.pcd", SweepFormat::kPcd));
  ASSERT_TRUE(read_sweep_file(folder / "a.pcd", read));
  EXPECT_FALSE(read.has_times);
  EXPECT_TRUE(read.ring == sweep.ring && read.x == sweep.x);
}

TEST(PcdTimes, TimesOutsideATurnAreAnError) {
  for (const char* time : {"-1", "2000000001", "nan"}) {
    const std::string file =
        make_header("FIELDS x y z time_offset_ns\nSIZE 4 4 4 8\nTYPE F F F F\nCOUNT 1 1 1 1\n", 1,
                    "ascii") +
        "1 2 3 " + time + "\n";
    Sweep sweep;
    EXPECT_FALSE(parse_pcd_sweep(file, sweep)) << time;
  }
}

TEST(PcdSweep, ReadsBinary) {
  const std::vector<SyntheticReturn> made = make_returns();
  std::string bytes = make_header(kXyziRingFields, made.size(), "binary");
  for (const SyntheticReturn& one : made) {
    bytes += to_bytes(static_cast<float>(one.x)) + to_bytes(static_cast<float>(one.y)) +
             to_bytes(static_cast<float>(one.z)) + to_bytes(static_cast<uint8_t>(one.intensity)) +
             to_bytes(static_cast<uint16_t>(one.ring_number)) + to_bytes(1.6e9);
  }
  Sweep sweep;
  ASSERT_TRUE(parse_pcd_sweep(bytes, sweep));
  expect_synthetic_returns(sweep);
}

TEST(PcdSweep, ReadsBinaryCompressed) {
  const std::vector<SyntheticReturn> made = make_returns();
  std::string x, y, z, intensity, ring, time;
  for (const SyntheticReturn& one : made) {
    x += to_bytes(static_cast<float>(one.x));
    y += to_bytes(static_cast<float>(one.y));
    z += to_bytes(static_cast<float>(one.z));
    intensity += to_bytes(static_cast<uint8_t>(one.intensity));
    ring += to_bytes(static_cast<uint16_t>(one.ring_number));
    time += to_bytes(1.6e9);
  }
  const std::string bytes = make_header(kXyziRingFields, made.size(), "binary_compressed") +
                            compress(x + y + z + intensity + ring + time) + "what follows";
  Sweep sweep;
  ASSERT_TRUE(parse_pcd_sweep(bytes, sweep));
  expect_synthetic_returns(sweep);
}

TEST(PcdSweep, ReadsAsciiAndIgnoresUnknownFields) {
  const std::string fields =
      "FIELDS normal intensity z y x _ laser\nSIZE 4 4 8 8 8 1 4\nTYPE F F F F F U I\n"
      "COUNT 3 1 1 1 1 2 1\n";
  const std::vector<SyntheticReturn> made = make_returns();
  std::string bytes = make_header(fields, made.size(), "ascii");
  for (const SyntheticReturn& one : made) {
    char line[200];
    std::snprintf(line, sizeof line, "0 0 1 %d %.9g %.9g\t%.9g 0 0 %d\r\n", one.intensity, one.z,
                  one.y, one.x, one.ring_number);
    bytes += line;
  }
  Sweep sweep;
  ASSERT_TRUE(parse_pcd_sweep(bytes, sweep)) << parse_error(bytes);
  expect_synthetic_returns(sweep);
}

TEST(PcdSweep, SkipsDirectionsWithoutAReturn) {
  Sweep sweep;
  ASSERT_TRUE(parse_pcd_sweep(make_header(kXyziFields, 5, "ascii") +
                                  "1 2 2 0.5\nnan nan nan 1\n0 0 0 0.25\n1e99 0 0 0\n0 3 0 nan\n",
                              sweep));
  ASSERT_EQ(sweep.size(), 2U);
  EXPECT_EQ(sweep.range[0], 3);
  EXPECT_EQ(sweep.reflectivity[0], 0.5F);
  EXPECT_EQ(sweep.y[1], 3);
  EXPECT_EQ(sweep.reflectivity[1], 0);
  EXPECT_EQ(sweep.rings, 0);
}

TEST(PcdSweep, AnEmptyCloudIsAnEmptySweep) {
  for (const char* data : {"ascii", "binary"}) {
    Sweep sweep;
    EXPECT_TRUE(parse_pcd_sweep(make_header(kXyziRingFields, 0, data), sweep)) << data;
    EXPECT_EQ(sweep.size(), 0U);
  }
}

TEST(PcdSweep, ErrorsDescribeTheProblem) {
  EXPECT_THAT(parse_error(""), HasSubstr("no DATA line"));
  EXPECT_THAT(parse_error("JUNK 1\n"), HasSubstr("line 1: JUNK is not a key"));
  EXPECT_THAT(parse_error("FIELDS x y\nSIZE 4\n"), HasSubstr("line 2: SIZE must have one entry"));
  EXPECT_THAT(parse_error("FIELDS x\nPOINTS 99999999999999999999\n"),
              HasSubstr("must be one number"));
  EXPECT_THAT(parse_error("FIELDS x\nSIZE 3\nPOINTS 1\nDATA ascii\n"), HasSubstr("field 'x'"));
  EXPECT_THAT(parse_error("FIELDS x\nWIDTH 2\nHEIGHT 2\nPOINTS 3\nDATA ascii\n"),
              HasSubstr("HEIGHT"));
  EXPECT_THAT(parse_error("FIELDS x y\nPOINTS 1\nDATA ascii\n1 2\n"), HasSubstr("x, y and z"));
  EXPECT_THAT(parse_error("FIELDS x y z\nPOINTS 1\nDATA zip\n"), HasSubstr("binary_compressed"));
  EXPECT_THAT(parse_error(make_header(kXyziFields, 2, "ascii") + "1 2 3 4\n1 2 x 4\n"),
              HasSubstr("point 1 has no number for z"));
  EXPECT_THAT(parse_error(make_header(kXyziFields, 2, "binary") + std::string(31, 'a')),
              HasSubstr("ends after 31 of 32 bytes"));
  const std::string four = to_bytes(1.F) + to_bytes(1.F) + to_bytes(1.F) + to_bytes(1.F);
  EXPECT_THAT(parse_error(make_header(kXyziFields, 2, "binary_compressed") + compress(four)),
              HasSubstr("decompresses to 16"));
  const std::string whole = make_header(kXyziFields, 1, "binary_compressed") + compress(four);
  EXPECT_EQ(parse_error(whole), "");
  EXPECT_THAT(parse_error(whole.substr(0, whole.size() - 1)), HasSubstr("ends within"));
  EXPECT_THAT(parse_error(make_header(kXyziFields, 1, "binary_compressed") + to_bytes(2U) +
                          to_bytes(16U) + "\x05\x05"),
              HasSubstr("cannot be decompressed"));
  EXPECT_THAT(parse_error(make_header(kXyziFields, 4'000'000, "binary_compressed") + to_bytes(2U) +
                          to_bytes(64'000'000U) + "aa"),
              HasSubstr("cannot be decompressed"));
}

TEST(PcdSweep, DamagedFilesAreReadOrRejected) {
  const std::vector<SyntheticReturn> made = make_returns();
  std::string points;
  for (const SyntheticReturn& one : made) points += to_bytes(static_cast<float>(one.x));
  const std::string sound = make_header("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n",
                                        made.size() / 3, "binary_compressed") +
                            compress(points.substr(0, made.size() / 3 * 12));
  std::mt19937 random(1);
  Sweep sweep;
  int refused = 0;
  for (int round = 0; round < 3000; ++round) {
    std::string bytes = sound;
    for (int k = 0; k < 3; ++k) bytes[random() % bytes.size()] = static_cast<char>(random());
    if (round % 3 == 0) bytes.resize(random() % bytes.size());
    if (!parse_pcd_sweep(bytes, sweep)) {
      ++refused;
    } else {
      EXPECT_LE(sweep.size(), 4'000'000U);
    }
  }
  EXPECT_GT(refused, 1000);
}

TEST(PcdSweep, ReadsExportedSweeps) {
  const ScratchFolder folder;
  Sweep sweep, again;
  std::string bytes = make_header(kXyziRingFields, make_returns().size(), "ascii");
  for (const SyntheticReturn& one : make_returns()) {
    bytes += std::to_string(one.x) + " " + std::to_string(one.y) + " " + std::to_string(one.z) +
             " " + std::to_string(one.intensity) + " " + std::to_string(one.ring_number) + " 0\n";
  }
  ASSERT_TRUE(parse_pcd_sweep(bytes, sweep));
  ASSERT_TRUE(export_sweep(sweep, folder / "a.pcd", SweepFormat::kPcd));
  ASSERT_TRUE(SweepReader().read(folder / "a.pcd", again));
  ASSERT_EQ(again.size(), sweep.size());
  for (size_t i = 0; i < sweep.size(); ++i) {
    EXPECT_EQ(again.x[i], sweep.x[i]);
    EXPECT_EQ(again.reflectivity[i], sweep.reflectivity[i]);
    EXPECT_EQ(again.ring[i], sweep.ring[i]);
  }
}

// Expected values counted with an independent decoder: a Pandar64 with 0.2° steps whose beams are
// numbered from below.
TEST(PcdSweep, ReadsRealOpenCalibScenes) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "calibration/opencalib");
  struct Expected {
    const char* file;
    size_t returns, lowest, highest;
  };
  for (const auto& [file, returns, lowest, highest] :
       {Expected{"scene2.pcd", 98805, 1483, 353}, Expected{"scene3.pcd", 85546, 1801, 351}}) {
    Sweep sweep;
    ASSERT_TRUE(SweepReader().read(folder / file, sweep)) << file;
    EXPECT_EQ(sweep.size(), returns);
    EXPECT_EQ(sweep.rings, 64);
    EXPECT_EQ(sweep.columns, 1800U);
    EXPECT_EQ(std::count(sweep.ring.begin(), sweep.ring.end(), 0), static_cast<long>(lowest));
    EXPECT_EQ(std::count(sweep.ring.begin(), sweep.ring.end(), 63), static_cast<long>(highest));
    EXPECT_NEAR(*std::max_element(sweep.reflectivity.begin(), sweep.reflectivity.end()),
                254 / 255.0, 1e-6);
  }
}

}  // namespace
}  // namespace infuse::recording
