// Needs a kernel with the virtual camera driver vivid at /dev/video0: ./dev vm.

#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <vector>

#include "drivers/camera/v4l2_source.hpp"

namespace infuse::camera {
namespace {

class VirtualCamera : public testing::Test {
 protected:
  void SetUp() override {
    if (access("/sys/module/vivid", F_OK) != 0) GTEST_SKIP() << "no vivid here: ./dev vm";
  }

  V4l2Source open(const V4l2Options& options) {
    auto source = V4l2Source::open(options, time_base_);
    EXPECT_TRUE(source.has_value()) << source.error().message();
    return *std::move(source);
  }

  /// Waits for `images` images and calls `on` with each.
  template <class OnImage>
  void stream(V4l2Source& source, int images, OnImage on) {
    for (int left = images; left > 0;) {
      pollfd waiting{source.descriptor(), POLLIN, 0};
      ASSERT_EQ(poll(&waiting, 1, 10'000), 1) << "no image arrived";
      const auto read = source.read([&](const StreamedImage& image) {
        on(image);
        --left;
      });
      ASSERT_TRUE(read.has_value()) << read.error().message();
    }
  }

  host::TimeBase time_base_;
};

TEST_F(VirtualCamera, StreamsWithRisingSequenceAndStampsBeforeNow) {
  V4l2Source source = open({.device = "/dev/video0", .width = 640, .height = 480});
  EXPECT_EQ(source.width(), 640);
  Stamp last = Stamp::earliest();
  uint64_t next = 0;
  stream(source, 15, [&](const StreamedImage& image) {
    EXPECT_GT(image.stamp, last);
    EXPECT_LT(image.stamp, time_base_.now() + Duration(50'000'000));  // half of the exposure ahead
    EXPECT_GT(image.stamp, time_base_.now() - Duration(10'000'000'000));
    EXPECT_GE(image.sequence + 1, next);  // vivid may count its first image twice
    next = image.sequence + 1;
    last = image.stamp;
  });
  EXPECT_EQ(source.counters().images, 15U);
}

TEST_F(VirtualCamera, EveryFormatGivesTheSameImage) {
  // vivid draws colour bars from the left: white first, black last.
  for (const RawFormat format :
       {RawFormat::kGrey, RawFormat::kYuyv, RawFormat::kUyvy, RawFormat::kRgb24, RawFormat::kBgr24,
        RawFormat::kBayerRggb, RawFormat::kBayerBggr, RawFormat::kBayerGbrg,
        RawFormat::kBayerGrbg}) {
    SCOPED_TRACE(name_of(format));
    V4l2Source source =
        open({.device = "/dev/video0", .width = 320, .height = 240, .format = format});
    EXPECT_EQ(source.format(), format);
    CameraFrame frame;
    stream(source, 2, [&](const StreamedImage& image) {
      const auto unpacked = unpack(image.raw, true, frame);
      ASSERT_TRUE(unpacked.has_value()) << unpacked.error().message();
    });
    ASSERT_EQ(frame.width, 320);
    ASSERT_EQ(frame.height, 240);
    const size_t row = 200 * frame.row_bytes();  // below the text that vivid writes
    const size_t pixel = static_cast<size_t>(channels(frame.format));
    EXPECT_GT(frame.pixels[row + 8 * pixel], 150);
    EXPECT_LT(frame.pixels[row + 312 * pixel], 60);
  }
}

TEST_F(VirtualCamera, ReportsUnsupportedSettings) {
  V4l2Options odd{.device = "/dev/video0", .width = 641, .height = 7};
  const auto size = V4l2Source::open(odd, time_base_);
  ASSERT_FALSE(size.has_value());
  EXPECT_NE(size.error().what.find("does not support 641x7"), std::string::npos)
      << size.error().what;
  const auto format =
      V4l2Source::open({.device = "/dev/video0", .format = RawFormat::kMjpeg}, time_base_);
  ASSERT_FALSE(format.has_value());
  EXPECT_NE(format.error().what.find("MJPEG"), std::string::npos);
}

TEST_F(VirtualCamera, SetsTheGainAndReadsItBack) {
  V4l2Source source = open({.device = "/dev/video0", .width = 640, .height = 480, .gain = 77});
  double gain = 0;
  stream(source, 1, [&](const StreamedImage& image) { gain = image.gain; });
  EXPECT_EQ(gain, 77);
}

TEST_F(VirtualCamera, ASecondReaderOfOneCameraIsRefused) {
  const V4l2Source first = open({.device = "/dev/video0"});
  const auto second = V4l2Source::open({.device = "/dev/video0"}, time_base_);
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(second.error().where, "/dev/video0");
}

}  // namespace
}  // namespace infuse::camera
