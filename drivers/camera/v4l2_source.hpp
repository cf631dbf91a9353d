#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/camera/raw_image.hpp"
#include "drivers/camera/v4l2_options.hpp"
#include "drivers/host/file_descriptor.hpp"
#include "drivers/host/time_base.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::camera {

/// Counters since the camera was opened.
struct V4l2Counters {
  uint64_t images = 0;   ///< delivered
  uint64_t lost = 0;     ///< missing by the driver's own counter
  uint64_t damaged = 0;  ///< marked as damaged by the driver
};

/// A local camera (Video4Linux2) that streams into memory shared with the driver.
class V4l2Source {
 public:
  /// Opens, configures and starts the camera. Errors: no such device (yet), no permission, in use,
  /// unsupported size, format or rate.
  static Result<V4l2Source> open(const V4l2Options& options, const host::TimeBase& base);
  V4l2Source(V4l2Source&&) noexcept = default;
  V4l2Source& operator=(V4l2Source&&) noexcept = default;
  ~V4l2Source();

  /// Readable when an image is pending; in error when the camera was unplugged.
  int descriptor() const { return device_.get(); }

  /// Dequeues the oldest pending image and calls `on(const StreamedImage&)` with it, unless the
  /// driver marks it as damaged; its bytes belong to the driver again when `on` returns. False if
  /// none is pending. An error means that the camera is gone: open another source later.
  template <class OnImage>
  Result<bool> read(OnImage on) {
    uint32_t buffer = 0;
    StreamedImage image;
    const auto dequeued = dequeue(buffer, image);
    if (!dequeued) return tl::unexpected(dequeued.error());
    if (*dequeued == Dequeued::kNone) return false;
    if (*dequeued == Dequeued::kImage) on(static_cast<const StreamedImage&>(image));
    if (const auto requeued = requeue(buffer); !requeued) return tl::unexpected(requeued.error());
    return true;
  }

  const V4l2Counters& counters() const { return counters_; }

  /// The settings in use: "GREY 640x480, 30.00 Hz".
  std::string description() const;

  RawFormat format() const { return image_layout_.format; }
  int width() const { return image_layout_.width; }
  int height() const { return image_layout_.height; }

 private:
  enum class Dequeued { kNone, kDamaged, kImage };

  /// A buffer of the driver, mapped into this process.
  class Mapping {
   public:
    Mapping(int device, size_t offset, size_t bytes);
    Mapping(Mapping&& other) noexcept;
    Mapping& operator=(Mapping&&) = delete;
    ~Mapping();
    std::span<const uint8_t> bytes() const { return bytes_; }

   private:
    std::span<uint8_t> bytes_;
  };

  V4l2Source(const V4l2Options& options, const host::TimeBase& base)
      : options_(options), base_(base) {}
  Result<void> check_capabilities();
  Result<void> negotiate();
  Result<void> set_rate();
  Result<void> set_controls();
  Result<void> start();
  Result<Dequeued> dequeue(uint32_t& buffer, StreamedImage& image);
  Result<void> requeue(uint32_t buffer);
  void read_controls(Stamp now);
  Stamp exposure_stamp(int64_t monotonic_ns, uint32_t flags) const;

  V4l2Options options_;
  host::TimeBase base_;
  bool no_bandwidth_ = false;  // the last start found its bus full
  host::FileDescriptor device_;
  std::vector<Mapping> buffers_;
  RawImage image_layout_;  // all but its bytes
  double rate_hz_ = 0;
  V4l2Counters counters_;
  uint32_t next_sequence_ = 0;
  Duration exposure_{0};
  double gain_ = 0;
  Stamp last_controls_read_ = Stamp::earliest();
};

}  // namespace infuse::camera
