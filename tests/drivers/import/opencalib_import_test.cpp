#include "drivers/import/opencalib_import.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/import/image_size.hpp"
#include "drivers/recording/drive_source.hpp"
#include "tests/drivers/import/png_header.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::importers {
namespace {

using ::testing::HasSubstr;
using namespace std::string_literals;

// The header of a PNG of 64 × 48 pixels; the import reads nothing else.
constexpr const char* kCalibration =
    "K: 100 0 31.5 0 101 23.5 0 0 1\nD: -0.1 0.2 0.001 0.002\n"
    "T: 0 -1 0 0.1 0 0 -1 -0.2 1 0 0 -0.3\n";
constexpr const char* kPcd =
    "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA "
    "ascii\n5 0 0\n6 1 0\n";

TEST(OpencalibImport, ImportsAScene) {
  const ScratchFolder folder;
  folder.write("in/a.calib.txt", kCalibration);
  folder.write("in/a.pcd", kPcd);
  folder.write("in/a.png", make_png());
  const auto imported = import_opencalib(folder / "in/a.calib.txt", folder / "drive");
  ASSERT_TRUE(imported) << imported.error().message();
  const auto drive = recording::Drive::open(folder / "drive");
  ASSERT_TRUE(drive) << drive.error().message();
  EXPECT_FALSE(drive->description.times_trusted);
  ASSERT_EQ(drive->description.rig.cameras.size(), 1U);
  const CameraMount& camera = drive->description.rig.cameras[0];
  EXPECT_EQ(camera.intrinsics.width, 64);
  EXPECT_EQ(camera.intrinsics.height, 48);
  EXPECT_EQ(camera.intrinsics.fy, 101);
  EXPECT_EQ(camera.intrinsics.cx, 31.5);
  EXPECT_EQ(camera.intrinsics.distortion, (std::array<double, 5>{-0.1, 0.2, 0.001, 0.002, 0}));
  // A point 5 m ahead has a depth of 4.7 m and lies 0.1 m to the right, 0.2 m up.
  const Eigen::Vector3d seen = camera.T_camera_lidar * Eigen::Vector3d(5, 0, 0);
  EXPECT_LT((seen - Eigen::Vector3d(0.1, -0.2, 4.7)).norm(), 1e-12);
  auto source = recording::DriveSource::open(*drive);
  ASSERT_TRUE(source);
  recording::DriveEvent event;
  size_t returns = 0, images = 0;
  while (source->next(event)) {
    if (const auto* sweep = std::get_if<recording::SweepEvent>(&event.content))
      returns = sweep->sweep->size();
    if (std::holds_alternative<recording::ImageEvent>(event.content)) ++images;
  }
  EXPECT_EQ(returns, 2U);
  EXPECT_EQ(images, 1U);
}

TEST(OpencalibImport, ErrorsNameWhatIsMissing) {
  const ScratchFolder folder;
  const auto import_error = [&] {
    const auto imported = import_opencalib(folder / "a.calib.txt", folder / "drive");
    return imported ? "" : imported.error().message();
  };
  EXPECT_THAT(import_error(), HasSubstr("cannot be opened"));
  folder.write("a.calib.txt", "K: 1 0 0 0 1 0 0 0 1\n");
  EXPECT_THAT(import_error(), HasSubstr("has no sweep in the same folder"));
  folder.write("a.pcd", kPcd);
  EXPECT_THAT(import_error(), HasSubstr("has no image in the same folder"));
  folder.write("a.png", "not an image");
  EXPECT_THAT(import_error(), HasSubstr("is not a PNG or JPEG image"));
  folder.write("a.png", make_png());
  EXPECT_THAT(import_error(), HasSubstr("has no T"));
  folder.write("a.calib.txt", "K: 1 0 0 0 1 0 0 0\nT: 1 0 0 0 0 1 0 0 0 0 1 0\n");
  EXPECT_THAT(import_error(), HasSubstr("K must be 9 numbers"));
  folder.write("a.calib.txt", "K: 1 0 0 0 1 0 0 0 1\nD: 1 2 3 4 5 6\nT: 1 0 0 0 0 1 0 0 0 0 1 0\n");
  EXPECT_THAT(import_error(), HasSubstr("at most 5"));
  folder.write("a.calib.txt", "K: 1 0 0 0 1 0 0 0 1\nT: 2 0 0 0 0 1 0 0 0 0 1 0\n");
  EXPECT_THAT(import_error(), HasSubstr("rigid"));
  EXPECT_FALSE(std::filesystem::exists(folder / "drive"));
  folder.write("a.calib.txt", kCalibration);
  folder.write("drive/file", "");
  EXPECT_THAT(import_error(), HasSubstr("not empty"));
}

TEST(ImageSize, ReadsJpegFrameHeaders) {
  const ScratchFolder folder;
  // An application segment of four bytes, then a progressive frame of 3 rows and 258 columns.
  folder.write("a.jpg", "\xFF\xD8\xFF\xE0\0\x04zz\xFF\xC2\0\x0B\x08\0\x03\x01\x02"s);
  EXPECT_EQ(read_image_size(folder / "a.jpg"), (ImageSize{258, 3}));
  folder.write("b.jpg", "\xFF\xD8\xFF\xE0\0\x04zz\xFF\xC2\0\x0B\x08\0\x03\x01"s);
  EXPECT_FALSE(read_image_size(folder / "b.jpg"));
  folder.write("c.jpg", "\xFF\xD8\xFF\xE0\0\x01zz"s);
  EXPECT_FALSE(read_image_size(folder / "c.jpg"));
  EXPECT_FALSE(read_image_size(folder / "none.jpg"));
}

TEST(ImageSize, ReadsRealImages) {
  INFUSE_REAL_DATA_OR_SKIP(data, "calibration/opencalib");
  EXPECT_EQ(read_image_size(data / "scene2.jpg"), (ImageSize{1920, 1200}));
  EXPECT_EQ(read_image_size(data / "scene3.png"), (ImageSize{1920, 1200}));
}

}  // namespace
}  // namespace infuse::importers
