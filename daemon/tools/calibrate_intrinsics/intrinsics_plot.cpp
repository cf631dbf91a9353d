#include "daemon/tools/calibrate_intrinsics/intrinsics_plot.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "daemon/drawing/label.hpp"

namespace infuse::daemon {
namespace {

constexpr int kMaxWidth = 1280;    // pixels of the plot
constexpr double kEnlarged = 100;  // times; the errors
constexpr double kFullColour = 3;  // times the corners' noise
constexpr Colour kEmptyCell = {24, 24, 24}, kFilledCell = {64, 64, 64}, kLegend = {0, 0, 0};
constexpr Colour kOutlier = {255, 255, 255}, kCircle = {200, 120, 255};

/// The plot, in pixels of the camera's image.
class IntrinsicsPlot {
 public:
  explicit IntrinsicsPlot(const CameraIntrinsics& camera)
      : scale_(std::min(1.0, static_cast<double>(kMaxWidth) / camera.width)),
        bottom_(static_cast<int>(std::lround(scale_ * camera.height))) {
    image_.width = static_cast<int>(std::lround(scale_ * camera.width));
    image_.height = bottom_ + 3 * label_height();
    image_.format = PixelFormat::kBgr8;
    image_.pixels.assign(image_.row_bytes() * static_cast<size_t>(image_.height), kLegend[0]);
  }

  void fill(Eigen::Vector2d from, Eigen::Vector2d to, const Colour& colour) {
    const int right = std::min(image_.width, static_cast<int>(scale_ * to.x()));
    const int low = std::min(bottom_, static_cast<int>(scale_ * to.y()));
    for (int y = static_cast<int>(scale_ * from.y()); y < low; ++y)
      for (int x = static_cast<int>(scale_ * from.x()); x < right; ++x) set(x, y, colour);
  }

  void line(Eigen::Vector2d from, Eigen::Vector2d to, const Colour& colour) {
    const double length = scale_ * (to - from).norm();
    for (double at = 0; at <= length; at += 0.5) {
      const Eigen::Vector2d pixel = scale_ * (from + (to - from) * (at / std::max(length, 0.5)));
      dot(pixel, colour);
    }
  }

  void circle(const Eigen::Vector2d& centre, double radius, const Colour& colour) {
    const double step = 0.5 / std::max(1.0, scale_ * radius);
    for (double angle = 0; angle < 2 * std::numbers::pi; angle += step)
      dot(scale_ * (centre + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle))), colour);
  }

  /// A mark and its meaning, from left to right below the image.
  void legend(const Colour& colour, std::string_view meaning) {
    const int top = bottom_ + label_height();
    for (int y = 0; y < label_height() - 4; ++y)
      for (int x = 0; x < label_height() - 4; ++x) set(next_ + x, top + y, colour);
    draw_label(image_, next_ + label_height(), top, meaning, {255, 255, 255});
    next_ += label_height() + label_width(meaning) + 16;
  }

  CameraFrame take() { return std::move(image_); }

 private:
  void dot(const Eigen::Vector2d& pixel, const Colour& colour) {
    const auto x = static_cast<int>(std::lround(pixel.x()));
    const auto y = static_cast<int>(std::lround(pixel.y()));
    if (y < bottom_) set(x, y, colour);
  }

  void set(int x, int y, const Colour& colour) {
    if (x < 0 || y < 0 || x >= image_.width || y >= image_.height) return;
    std::ranges::copy(colour, image_.pixels.begin() +
                                  static_cast<std::ptrdiff_t>(image_.row_bytes()) * y + 3 * x);
  }

  double scale_;
  int bottom_;
  int next_ = 8;
  CameraFrame image_;
};

void draw_cells(const target::IntrinsicsResult& result, IntrinsicsPlot& plot) {
  using target::ImageCoverage;
  const Eigen::Vector2d cell(static_cast<double>(result.camera.width) / ImageCoverage::kColumns,
                             static_cast<double>(result.camera.height) / ImageCoverage::kRows);
  for (int row = 0; row < ImageCoverage::kRows; ++row) {
    for (int column = 0; column < ImageCoverage::kColumns; ++column) {
      const Eigen::Vector2d from(column * cell.x(), row * cell.y());
      const auto k = static_cast<size_t>(row * ImageCoverage::kColumns + column);
      plot.fill(from, from + cell, result.coverage.cells[k] > 0 ? kFilledCell : kEmptyCell);
    }
  }
}

}  // namespace

CameraFrame draw_intrinsics(const target::IntrinsicsResult& result,
                            std::span<const target::Corners> views) {
  IntrinsicsPlot plot(result.camera);
  draw_cells(result, plot);
  const Eigen::Vector2d centre(result.camera.cx, result.camera.cy);
  plot.circle(centre, result.coverage.radius, kCircle);
  const double full = kFullColour * std::max(result.corner_noise, 1e-3);
  for (size_t v = 0; v < views.size(); ++v) {
    const target::IntrinsicsView& view = result.views[v];
    for (size_t i = 0; i < views[v].size() && view.residual.size() > 0; ++i) {
      const Eigen::Vector2d error = view.residual.segment<2>(static_cast<Eigen::Index>(2 * i));
      plot.line(views[v][i], views[v][i] + kEnlarged * error,
                view.used ? fraction_colour(error.norm() / full) : kOutlier);
    }
  }
  plot.legend(kEmptyCell, "no corners");
  plot.legend(kFilledCell, "corners");
  plot.legend(kCircle, "distortion known within");
  plot.legend(fraction_colour(0), "error 0");
  plot.legend(fraction_colour(1), "error 3 sigma");
  plot.legend(kOutlier, "not used");
  return plot.take();
}

}  // namespace infuse::daemon
