#include "drivers/recording/sweep_export.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "tests/scratch_folder.hpp"

namespace infuse::recording {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

Sweep two_returns() {
  Sweep sweep;
  sweep.resize(2);
  sweep.stamp = Stamp::from_ns(1234);
  for (size_t i = 0; i < 2; ++i) {
    const auto f = static_cast<float>(i);
    sweep.x[i] = 1.5f + f;
    sweep.y[i] = -2;
    sweep.z[i] = 0.25f;
    sweep.range[i] = 3;
    sweep.reflectivity[i] = 0.5f;
    sweep.ring[i] = static_cast<uint16_t>(40000 + i);
    sweep.column[i] = 7;
    sweep.time_offset_ns[i] = -9;
    sweep.return_kind[i] = ReturnKind::kBoth;
  }
  return sweep;
}

template <class Value>
Value read_at(const std::string& bytes, size_t offset) {
  Value value{};
  std::memcpy(&value, bytes.data() + offset, sizeof(Value));
  return value;
}

// A packed record of 29 bytes after the header.
void expect_records(const std::string& bytes, const std::string& end_of_header) {
  const size_t header = bytes.find(end_of_header) + end_of_header.size();
  ASSERT_EQ(bytes.size() - header, 2 * 29u);
  for (size_t i = 0; i < 2; ++i) {
    const size_t record = header + 29 * i;
    EXPECT_EQ(read_at<float>(bytes, record), 1.5f + static_cast<float>(i));
    EXPECT_EQ(read_at<float>(bytes, record + 4), -2);
    EXPECT_EQ(read_at<float>(bytes, record + 8), 0.25f);
    EXPECT_EQ(read_at<float>(bytes, record + 12), 3);
    EXPECT_EQ(read_at<float>(bytes, record + 16), 0.5f);
    EXPECT_EQ(read_at<uint16_t>(bytes, record + 20), 40000 + i);
    EXPECT_EQ(read_at<uint16_t>(bytes, record + 22), 7);
    EXPECT_EQ(read_at<int32_t>(bytes, record + 24), -9);
    EXPECT_EQ(read_at<uint8_t>(bytes, record + 28), 2);
  }
}

TEST(SweepExport, EveryFormatContainsEveryField) {
  const ScratchFolder folder;
  const Sweep sweep = two_returns();
  ASSERT_TRUE(export_sweep(sweep, folder / "a.pcd", SweepFormat::kPcd));
  ASSERT_TRUE(export_sweep(sweep, folder / "a.ply", SweepFormat::kPly));
  ASSERT_TRUE(export_sweep(sweep, folder / "a.csv", SweepFormat::kCsv));
  ASSERT_TRUE(export_sweep(sweep, folder / "a.bin", SweepFormat::kBin));

  const std::string pcd = folder.read("a.pcd");
  EXPECT_THAT(pcd, StartsWith("# .PCD v0.7\n# stamp_ns 1234\nVERSION 0.7\nFIELDS x y z "));
  EXPECT_THAT(pcd, HasSubstr("WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\n"));
  expect_records(pcd, "DATA binary\n");
  const std::string ply = folder.read("a.ply");
  EXPECT_THAT(ply, StartsWith("ply\nformat binary_little_endian 1.0\ncomment stamp_ns 1234\n"
                              "element vertex 2\nproperty float x\n"));
  expect_records(ply, "end_header\n");
  EXPECT_EQ(folder.read("a.csv"),
            "x,y,z,range,reflectivity,ring,column,time_offset_ns,return_kind\n"
            "1.5,-2,0.25,3,0.5,40000,7,-9,2\n"
            "2.5,-2,0.25,3,0.5,40001,7,-9,2\n");
  const std::string bin = folder.read("a.bin");
  ASSERT_EQ(bin.size(), 32u);
  EXPECT_EQ(read_at<float>(bin, 16), 2.5f);
  EXPECT_EQ(read_at<float>(bin, 28), 0.5f);
}

TEST(SweepExport, FormatsAreDetectedByExtension) {
  EXPECT_EQ(detect_sweep_format("a/b.pcd"), SweepFormat::kPcd);
  EXPECT_EQ(detect_sweep_format("b.ply"), SweepFormat::kPly);
  EXPECT_EQ(detect_sweep_format("b.csv"), SweepFormat::kCsv);
  EXPECT_EQ(detect_sweep_format("b.bin"), SweepFormat::kBin);
  EXPECT_FALSE(detect_sweep_format("b.las"));
  EXPECT_FALSE(export_sweep(two_returns(), "/does/not/exist.pcd", SweepFormat::kPcd));
}

}  // namespace
}  // namespace infuse::recording
