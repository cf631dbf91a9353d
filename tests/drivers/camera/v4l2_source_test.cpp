// The device side of Video4Linux2 is scripted here: formats and controls that vivid, the virtual
// camera of ./dev vm, does not have.

#include "drivers/camera/v4l2_source.hpp"

#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <sys/syscall.h>

#include <cstdarg>

#include "tests/drivers/camera/jpeg_file.hpp"
#include "tests/drivers/camera/scripted_device.hpp"

namespace {

infuse::camera::testing::ScriptedDevice* scripted = nullptr;

}  // namespace

/// Replaces the system's ioctl in this program: calls for a scripted device go to it, all others to
/// the kernel.
extern "C" int ioctl(int descriptor, unsigned long request, ...) noexcept {
  va_list arguments;
  va_start(arguments, request);
  void* argument = va_arg(arguments, void*);
  va_end(arguments);
  if (scripted != nullptr && scripted->matches(descriptor))
    return scripted->handle_ioctl(request, argument);
  return static_cast<int>(syscall(SYS_ioctl, descriptor, request, argument));
}

namespace infuse::camera {
namespace {

using testing::make_jpeg;
using testing::ScriptedDevice;
using testing::ScriptedImage;

class ScriptedCamera : public ::testing::Test {
 protected:
  void SetUp() override { scripted = &device_; }
  void TearDown() override { scripted = nullptr; }

  V4l2Source open(V4l2Options options = {}) {
    options.device = device_.path();
    auto source = V4l2Source::open(options, base_);
    EXPECT_TRUE(source.has_value()) << source.error().message();
    return *std::move(source);
  }

  /// All pending images, without their bytes.
  std::vector<StreamedImage> read_all(V4l2Source& source) {
    std::vector<StreamedImage> images;
    while (true) {
      const auto read = source.read([&](const StreamedImage& p) { images.push_back(p); });
      EXPECT_TRUE(read.has_value()) << read.error().message();
      if (!read || !*read) return images;
    }
  }

  ScriptedDevice device_;
  host::TimeBase base_;
};

/// The same file without its Huffman tables (segments FF C4), as many cameras send it.
std::vector<uint8_t> without_huffman_tables(const std::vector<uint8_t>& file) {
  std::vector<uint8_t> stripped(file.begin(), file.begin() + 2);
  size_t at = 2;
  while (file[at + 1] != 0xDA) {  // up to the scan
    const size_t end = at + 2 + (size_t{file[at + 2]} << 8 | file[at + 3]);
    if (file[at + 1] != 0xC4) {
      stripped.insert(stripped.end(), file.begin() + static_cast<ptrdiff_t>(at),
                      file.begin() + static_cast<ptrdiff_t>(end));
    }
    at = end;
  }
  stripped.insert(stripped.end(), file.begin() + static_cast<ptrdiff_t>(at), file.end());
  return stripped;
}

TEST_F(ScriptedCamera, MotionJpegIsDecoded) {
  const auto whole = make_jpeg(64, 48, TJSAMP_422);
  const auto stripped = without_huffman_tables(whole);
  ASSERT_LT(stripped.size(), whole.size());
  device_.images.push_back({.bytes = whole, .sequence = 0});
  device_.images.push_back({.bytes = stripped, .sequence = 1});
  V4l2Source source = open({.width = 64, .height = 48, .format = RawFormat::kMjpeg});
  EXPECT_EQ(source.format(), RawFormat::kMjpeg);
  for (int i = 0; i < 2; ++i) {
    CameraFrame frame;
    const auto read = source.read([&](const StreamedImage& image) {
      const auto unpacked = unpack(image.raw, false, frame);
      ASSERT_TRUE(unpacked.has_value()) << unpacked.error().message();
    });
    ASSERT_TRUE(read.has_value());
    ASSERT_EQ(frame.width, 64);
    ASSERT_EQ(frame.height, 48);
    const size_t at = 20 * frame.row_bytes() + size_t{3} * 40;
    EXPECT_NEAR(frame.pixels[at], 80, 6);      // B: twice the column
    EXPECT_NEAR(frame.pixels[at + 1], 40, 6);  // G: twice the row
    EXPECT_NEAR(frame.pixels[at + 2], 90, 6);
  }
}

TEST_F(ScriptedCamera, ExposureAndGainAreSetAndReadIntoEveryImage) {
  device_.controls = {{V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_APERTURE_PRIORITY},
                      {V4L2_CID_EXPOSURE_ABSOLUTE, 333},
                      {V4L2_CID_AUTOGAIN, 1},
                      {V4L2_CID_GAIN, 5}};
  for (uint32_t i = 0; i < 2; ++i) device_.images.push_back({.bytes = {1}, .sequence = i});
  V4l2Source source = open({.exposure = Duration(8'000'000), .gain = 12});
  EXPECT_EQ(device_.controls[V4L2_CID_EXPOSURE_AUTO], V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(device_.controls[V4L2_CID_EXPOSURE_ABSOLUTE], 80);  // of 100 us
  EXPECT_EQ(device_.controls[V4L2_CID_AUTOGAIN], 0);
  const auto images = read_all(source);
  ASSERT_EQ(images.size(), 2U);
  for (const StreamedImage& image : images) {
    EXPECT_EQ(image.exposure, Duration(8'000'000));
    EXPECT_EQ(image.gain, 12);
  }
}

TEST_F(ScriptedCamera, AutomaticExposureAndGainAreReported) {
  device_.controls = {{V4L2_CID_EXPOSURE_ABSOLUTE, 333}, {V4L2_CID_GAIN, 5}};
  device_.images.push_back({.bytes = {1}});
  V4l2Source source = open();
  const auto images = read_all(source);
  ASSERT_EQ(images.size(), 1U);
  EXPECT_EQ(images[0].exposure, Duration(33'300'000));
  EXPECT_EQ(images[0].gain, 5);
}

TEST_F(ScriptedCamera, TheStampIsTheMiddleOfTheExposure) {
  device_.controls = {{V4L2_CID_EXPOSURE_ABSOLUTE, 100}};  // 10 ms
  constexpr int64_t kUs = 123'456'789;
  constexpr uint32_t kMonotonic = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  device_.images.push_back(
      {.bytes = {1}, .flags = kMonotonic | V4L2_BUF_FLAG_TSTAMP_SRC_SOE, .monotonic_us = kUs});
  device_.images.push_back(
      {.bytes = {1}, .flags = kMonotonic | V4L2_BUF_FLAG_TSTAMP_SRC_EOF, .monotonic_us = kUs});
  V4l2Source source = open({.stamp_delay = Duration(2'000'000)});
  const auto images = read_all(source);
  ASSERT_EQ(images.size(), 2U);
  const Stamp reported = base_.at_monotonic(kUs * 1000);
  EXPECT_EQ(images[0].stamp, reported + Duration(3'000'000));
  EXPECT_EQ(images[1].stamp, reported - Duration(7'000'000));
}

TEST_F(ScriptedCamera, GapsAreCountedAndDamagedImagesAreDropped) {
  for (const uint32_t sequence : {5U, 6U, 9U, 10U}) {
    device_.images.push_back({.bytes = {1}, .sequence = sequence});
  }
  device_.images[3].flags |= V4L2_BUF_FLAG_ERROR;
  V4l2Source source = open();
  const int requeued_before = device_.requeued;
  const auto images = read_all(source);
  ASSERT_EQ(images.size(), 3U);
  EXPECT_EQ(images[2].sequence, 9U);
  EXPECT_EQ(source.counters().lost, 2U);
  EXPECT_EQ(source.counters().damaged, 1U);
  EXPECT_EQ(device_.requeued, requeued_before + 4);  // including the buffer of the damaged image
}

TEST_F(ScriptedCamera, UnpluggingIsAnError) {
  device_.images.push_back({.bytes = {1}});
  V4l2Source source = open();
  EXPECT_EQ(read_all(source).size(), 1U);
  device_.unplugged = true;
  const auto read = source.read([](const StreamedImage&) {});
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().where, device_.path());
}

TEST_F(ScriptedCamera, WrongBufferSizeAndIndexAreRejected) {
  device_.images.push_back({.bytes = {1, 2, 3}, .bytes_used = 1U << 30});
  device_.images.push_back({.bytes = {1}, .buffer = 77});
  V4l2Source source = open();
  size_t bytes = 0;
  const auto read = source.read([&](const StreamedImage& p) { bytes = p.raw.bytes.size(); });
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(bytes, ScriptedDevice::kBufferBytes);
  EXPECT_FALSE(source.read([](const StreamedImage&) {}).has_value());
}

TEST_F(ScriptedCamera, UnsupportedSettingsAreErrors) {
  const auto size =
      V4l2Source::open({.device = device_.path(), .width = 640, .height = 480}, base_);
  ASSERT_FALSE(size.has_value());
  EXPECT_NE(size.error().what.find("640x480"), std::string::npos);
  EXPECT_FALSE(
      V4l2Source::open({.device = device_.path(), .exposure = Duration(1'000'000)}, base_));
  EXPECT_FALSE(V4l2Source::open({.device = device_.path(), .gain = 1}, base_));
  device_.formats = {V4L2_PIX_FMT_H264};
  EXPECT_FALSE(V4l2Source::open({.device = device_.path()}, base_));
  EXPECT_FALSE(device_.streaming);
}

TEST_F(ScriptedCamera, StreamingStopsWithTheSource) {
  {
    const V4l2Source source = open();
    EXPECT_TRUE(device_.streaming);
  }
  EXPECT_FALSE(device_.streaming);
}

}  // namespace
}  // namespace infuse::camera
