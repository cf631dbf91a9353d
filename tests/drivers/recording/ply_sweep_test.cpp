#include "drivers/recording/ply_sweep.hpp"

#include <gtest/gtest.h>

#include "drivers/recording/sweep_export.hpp"
#include "drivers/recording/sweep_files.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::recording {
namespace {

constexpr const char* kText =
    "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 3\nproperty float x\n"
    "property double y\nproperty float32 z\nproperty uchar scalar_intensity\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "1 2 3 255\nnan 0 0 10\n4 5 6 51\n3 0 1 2\n";

TEST(PlySweep, ReadsTextWithFacesBehindThePoints) {
  Sweep sweep;
  const auto parsed = parse_ply_sweep(kText, sweep);
  ASSERT_TRUE(parsed) << parsed.error().message();
  ASSERT_EQ(sweep.size(), 2U);
  EXPECT_EQ(sweep.y[0], 2);
  EXPECT_EQ(sweep.z[1], 6);
  EXPECT_FLOAT_EQ(sweep.reflectivity[1], 0.2F);
}

TEST(PlySweep, ReadsBackWhatIsExported) {
  const ScratchFolder folder;
  Sweep sweep;
  sweep.resize(2);
  for (size_t i = 0; i < 2; ++i) {
    sweep.x[i] = 1.5F + static_cast<float>(i);
    sweep.y[i] = -2;
    sweep.z[i] = 0.25F;
    sweep.range[i] = 3;
    sweep.reflectivity[i] = 0.5F;
    sweep.ring[i] = sweep.column[i] = 0;
    sweep.time_offset_ns[i] = 0;
    sweep.return_kind[i] = ReturnKind::kStrongest;
  }
  const auto path = folder / "a.ply";
  ASSERT_TRUE(export_sweep(sweep, path, SweepFormat::kPly));
  Sweep read;
  const auto done = read_sweep_file(path, read);
  ASSERT_TRUE(done) << done.error().message();
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read.x[1], 2.5F);
  EXPECT_EQ(read.reflectivity[0], 0.5F);
}

TEST(PlySweep, StatesWhatIsWrong) {
  const auto message = [](std::string text) {
    Sweep sweep;
    const auto parsed = parse_ply_sweep(text, sweep);
    return parsed ? std::string() : parsed.error().message();
  };
  EXPECT_NE(message(""), "");
  EXPECT_NE(message("ply\nformat ascii 1.0\n").find("end_header"), std::string::npos);
  EXPECT_NE(message("pcd\n").find("not a PLY file"), std::string::npos);
  const std::string start = "ply\nformat ";
  EXPECT_NE(message(start + "binary_big_endian 1.0\n").find("line 2"), std::string::npos);
  EXPECT_NE(message(start + "ascii 1.0\nelement face 3\n").find("vertex"), std::string::npos);
  EXPECT_NE(message(start + "ascii 1.0\nelement vertex 5000000\n").find("4 million"),
            std::string::npos);
  EXPECT_NE(message(start + "ascii 1.0\nelement vertex 1\nproperty list uchar int a\n"), "");
  EXPECT_NE(message(start + "ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n")
                .find("x, y and z"),
            std::string::npos);
  EXPECT_NE(message(start + "binary_little_endian 1.0\nelement vertex 9\nproperty float x\n"
                            "property float y\nproperty float z\nend_header\nabc")
                .find("ends after"),
            std::string::npos);
}

TEST(PlySweep, RealCloudOfARegistrationPairIsRead) {
  INFUSE_REAL_DATA_OR_SKIP(path, "registration/pair/source.ply");
  Sweep sweep;
  const auto read = read_sweep_file(path, sweep);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(sweep.size(), 69'792U - 5107U);  // so many points lie at the origin
}

}  // namespace
}  // namespace infuse::recording
