#pragma once

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <map>
#include <string>
#include <vector>

namespace infuse::camera::testing {

/// An image that a scripted device delivers.
struct ScriptedImage {
  std::vector<uint8_t> bytes;
  uint32_t sequence = 0;
  uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_EOF;
  int64_t monotonic_us = 0;
  uint32_t bytes_used = 0;          ///< reported size; 0: the actual size
  uint32_t buffer = kActualBuffer;  ///< reported buffer; kActualBuffer: the actual one

  static constexpr uint32_t kActualBuffer = 99;
};

/// A Video4Linux2 device without a driver: the test program's own `ioctl` calls it. A plain file
/// represents the device, its contents the buffers.
class ScriptedDevice {
 public:
  static constexpr uint32_t kBufferBytes = 64 << 10;  // a multiple of a page

  ScriptedDevice() {
    path_ = "/tmp/infuse-scripted-device-XXXXXX";
    file_ = mkstemp(path_.data());
  }
  ~ScriptedDevice() {
    close(file_);
    unlink(path_.c_str());
  }
  ScriptedDevice(const ScriptedDevice&) = delete;
  ScriptedDevice& operator=(const ScriptedDevice&) = delete;

  /// Path to open.
  const std::string& path() const { return path_; }

  // Supported formats, settings and content.
  std::vector<uint32_t> formats = {V4L2_PIX_FMT_MJPEG};
  uint32_t width = 64;                   ///< pixels, whatever is requested
  uint32_t height = 48;                  ///< pixels, whatever is requested
  std::map<uint32_t, int32_t> controls;  ///< by identifier; others are refused
  std::deque<ScriptedImage> images;      ///< to be delivered
  bool unplugged = false;

  // Observed calls.
  bool streaming = false;
  int requeued = 0;  ///< number of buffers queued, the initial ones included

  /// True if the descriptor belongs to this device.
  bool matches(int descriptor) const {
    struct stat mine {
    }, other{};
    return fstat(file_, &mine) == 0 && fstat(descriptor, &other) == 0 &&
           mine.st_ino == other.st_ino && mine.st_dev == other.st_dev;
  }

  /// Handles an ioctl like a driver: 0, or −1 and errno.
  int handle_ioctl(unsigned long request, void* argument) {
    if (unplugged) return fail_with(ENODEV);
    switch (request) {
      case VIDIOC_QUERYCAP: {
        auto& about = *static_cast<v4l2_capability*>(argument);
        about.capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
        return 0;
      }
      case VIDIOC_ENUM_FMT: {
        auto& about = *static_cast<v4l2_fmtdesc*>(argument);
        if (about.index >= formats.size()) return fail_with(EINVAL);
        about.pixelformat = formats[about.index];
        return 0;
      }
      case VIDIOC_G_FMT:
      case VIDIOC_S_FMT: {
        auto& pixels = static_cast<v4l2_format*>(argument)->fmt.pix;
        pixels.width = width;
        pixels.height = height;
        return 0;
      }
      case VIDIOC_S_CTRL:
      case VIDIOC_G_CTRL: {
        auto& about = *static_cast<v4l2_control*>(argument);
        const auto control = controls.find(about.id);
        if (control == controls.end()) return fail_with(EINVAL);
        if (request == VIDIOC_S_CTRL) control->second = about.value;
        about.value = control->second;
        return 0;
      }
      case VIDIOC_REQBUFS: {
        const uint32_t count = static_cast<v4l2_requestbuffers*>(argument)->count;
        return ftruncate(file_, static_cast<off_t>(count * kBufferBytes));
      }
      case VIDIOC_QUERYBUF: {
        auto& about = *static_cast<v4l2_buffer*>(argument);
        about.m.offset = about.index * kBufferBytes;
        about.length = kBufferBytes;
        return 0;
      }
      case VIDIOC_QBUF:
        free_buffers_.push_back(static_cast<v4l2_buffer*>(argument)->index);
        ++requeued;
        return 0;
      case VIDIOC_DQBUF:
        return dequeue(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_STREAMON:
      case VIDIOC_STREAMOFF:
        streaming = request == VIDIOC_STREAMON;
        return 0;
      default:  // rates
        return fail_with(ENOTTY);
    }
  }

 private:
  static int fail_with(int number) {
    errno = number;
    return -1;
  }

  int dequeue(v4l2_buffer& about) {
    if (images.empty() || free_buffers_.empty() || !streaming) return fail_with(EAGAIN);
    const ScriptedImage image = images.front();
    images.pop_front();
    const uint32_t buffer = free_buffers_.front();
    free_buffers_.pop_front();
    const auto bytes = static_cast<ssize_t>(image.bytes.size());
    if (pwrite(file_, image.bytes.data(), image.bytes.size(),
               static_cast<off_t>(buffer * kBufferBytes)) != bytes) {
      return fail_with(EIO);
    }
    about.index = image.buffer == ScriptedImage::kActualBuffer ? buffer : image.buffer;
    about.bytesused = image.bytes_used != 0 ? image.bytes_used : static_cast<uint32_t>(bytes);
    about.sequence = image.sequence;
    about.flags = image.flags;
    about.timestamp = {image.monotonic_us / 1'000'000, image.monotonic_us % 1'000'000};
    return 0;
  }

  std::string path_;
  int file_;
  std::deque<uint32_t> free_buffers_;  // buffers
};

}  // namespace infuse::camera::testing
