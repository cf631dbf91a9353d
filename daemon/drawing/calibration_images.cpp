#include "daemon/drawing/calibration_images.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "daemon/drawing/colour_scale.hpp"
#include "drivers/camera/png_encoder.hpp"
#include "fusion/calibration/scene.hpp"
#include "fusion/calibration/visible_points.hpp"

namespace infuse::daemon {
namespace {

/// The image in colour, darkened so that the overlay stands out.
CameraFrame darkened_image(const CameraFrame& frame) {
  CameraFrame out;
  out.width = frame.width;
  out.height = frame.height;
  out.format = PixelFormat::kBgr8;
  const auto step = static_cast<size_t>(channels(frame.format));
  const size_t pixels = static_cast<size_t>(frame.width) * static_cast<size_t>(frame.height);
  out.pixels.resize(3 * pixels);
  for (size_t i = 0; i < pixels; ++i) {
    for (size_t c = 0; c < 3; ++c) {
      const int value = frame.pixels[step * i + (step == 3 ? c : 0)];
      out.pixels[3 * i + c] = static_cast<uint8_t>(value * 3 / 4);
    }
  }
  return out;
}

void draw_dot(CameraFrame& frame, double u, double v, const Colour& colour) {
  const int left = static_cast<int>(u);
  const int top = static_cast<int>(v);
  for (int y = top; y <= std::min(top + 1, frame.height - 1); ++y) {
    for (int x = left; x <= std::min(left + 1, frame.width - 1); ++x) {
      const size_t at =
          3 * (static_cast<size_t>(y) * static_cast<size_t>(frame.width) + static_cast<size_t>(x));
      std::copy(colour.begin(), colour.end(), frame.pixels.begin() + static_cast<long>(at));
    }
  }
}

std::string encode_base64(std::span<const uint8_t> bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t three = 0;
    for (size_t k = 0; k < 3; ++k) three = three << 8 | (i + k < bytes.size() ? bytes[i + k] : 0U);
    for (size_t k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? kDigits[three >> (18 - 6 * k) & 63] : '=';
    }
  }
  return text;
}

}  // namespace

std::vector<size_t> choose_drawn(const ScenePairs& pairs, size_t count) {
  std::vector<size_t> all, chosen;
  for (size_t k = 0; k < pairs.pairs.size(); ++k) {
    if (pairs.pairs[k].has_data()) all.push_back(k);
  }
  count = std::min(count, all.size());
  for (size_t k = 0; k < count; ++k) chosen.push_back(all[(2 * k + 1) * all.size() / (2 * count)]);
  return chosen;
}

CameraFrame draw_overlay(const ScenePair& pair, const CameraIntrinsics& intrinsics,
                         const Eigen::Isometry3d& T_camera_lidar) {
  CameraFrame frame = darkened_image(pair.frame);
  calibration::Scene scene;
  for (size_t i = 0; i < pair.sweep.size(); ++i) {
    if (!(pair.sweep.range[i] > 1)) continue;
    scene.x.push_back(pair.sweep.x[i]);
    scene.y.push_back(pair.sweep.y[i]);
    scene.z.push_back(pair.sweep.z[i]);
  }
  const calibration::RigCamera camera{geometry::CameraModel(intrinsics)};
  const auto points =
      calibration::select_visible(std::span(&scene, 1), std::span(&camera, 1), T_camera_lidar, {});
  for (size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d p =
        T_camera_lidar * Eigen::Vector3d(points.x[i], points.y[i], points.z[i]);
    const auto pixel = camera.model.project(p);
    if (!pixel || !camera.model.in_image(*pixel)) continue;
    draw_dot(frame, std::max(pixel->x(), 0.0), std::max(pixel->y(), 0.0), range_colour(p.norm()));
  }
  return frame;
}

CameraFrame join_images(std::span<const CameraFrame> images, int columns) {
  int column_width = 0, row_height = 0;
  for (const CameraFrame& image : images) {
    column_width = std::max(column_width, image.width);
    row_height = std::max(row_height, image.height);
  }
  const int rows = (static_cast<int>(images.size()) + columns - 1) / columns;
  CameraFrame joint;
  joint.width = columns * column_width;
  joint.height = rows * row_height;
  joint.format = images.front().format;
  joint.pixels.assign(joint.row_bytes() * static_cast<size_t>(joint.height), 0);
  const auto pixel_bytes = static_cast<size_t>(channels(joint.format));
  for (size_t k = 0; k < images.size(); ++k) {
    const CameraFrame& image = images[k];
    const size_t left = k % static_cast<size_t>(columns) * static_cast<size_t>(column_width);
    const size_t top = k / static_cast<size_t>(columns) * static_cast<size_t>(row_height);
    for (size_t v = 0; v < static_cast<size_t>(image.height); ++v) {
      std::copy_n(image.pixels.begin() + static_cast<std::ptrdiff_t>(v * image.row_bytes()),
                  image.row_bytes(),
                  joint.pixels.begin() + static_cast<std::ptrdiff_t>((top + v) * joint.row_bytes() +
                                                                     left * pixel_bytes));
    }
  }
  return joint;
}

CameraFrame draw_map(std::span<const double> values, int columns) {
  const auto [min_value, max_value] = std::minmax_element(values.begin(), values.end());
  const double span = std::max(*max_value - *min_value, 1e-300);
  CameraFrame frame;
  frame.width = columns;
  frame.height = static_cast<int>(values.size()) / columns;
  frame.format = PixelFormat::kGrey8;
  for (int row = frame.height - 1; row >= 0; --row) {
    for (int column = 0; column < columns; ++column) {
      const double value = values[static_cast<size_t>(row * columns + column)];
      frame.pixels.push_back(static_cast<uint8_t>(255 * (value - *min_value) / span));
    }
  }
  return frame;
}

std::string data_url(const CameraFrame& frame) {
  const auto png = camera::encode_png(frame);
  return png ? "data:image/png;base64," + encode_base64(*png) : std::string();
}

}  // namespace infuse::daemon
