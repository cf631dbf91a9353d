#include "daemon/pipeline/image_match.hpp"

#include <algorithm>

namespace infuse::daemon {
namespace {

/// Sets the brightness figures from every eighth pixel of every eighth row.
void measure_brightness(const CameraFrame& frame, FrameReport& report) {
  constexpr size_t kStep = 8;
  constexpr uint8_t kMaxDark = 8, kMinBright = 247;
  const size_t pixel = static_cast<size_t>(channels(frame.format));
  const size_t middle = pixel == 3 ? 1 : 0;  // green approximates luminance
  uint64_t sum = 0, count = 0, dark = 0, bright = 0;
  for (size_t row = 0; row < static_cast<size_t>(frame.height); row += kStep) {
    const uint8_t* values = frame.pixels.data() + row * frame.row_bytes();
    for (size_t at = middle; at < frame.row_bytes(); at += kStep * pixel) {
      sum += values[at];
      dark += values[at] <= kMaxDark ? 1 : 0;
      bright += values[at] >= kMinBright ? 1 : 0;
      ++count;
    }
  }
  const double all = static_cast<double>(std::max<uint64_t>(count, 1));
  report.mean_brightness = static_cast<double>(sum) / all / 255;
  report.dark = static_cast<double>(dark) / all;
  report.bright = static_cast<double>(bright) / all;
}

}  // namespace

FrameReport summarise(const ImageMatch& match, std::string_view device) {
  const CameraImage& image = match.image;
  const Sweep& sweep = match.snapshot.sweep;
  FrameReport report;
  report.device = device;
  report.stamp = image.stamp;
  report.sequence = image.frame.sequence;
  report.width = static_cast<uint32_t>(image.frame.width);
  report.height = static_cast<uint32_t>(image.frame.height);
  measure_brightness(image.frame, report);
  report.sweep = sweep.sequence;
  report.sweep_offset = image.stamp - sweep.stamp;
  report.reason = match.reason;
  if (match.usable()) report.deskew_reason = match.snapshot.deskewed.reason;
  report.points_in_view = match.points_in_view;
  return report;
}

}  // namespace infuse::daemon
