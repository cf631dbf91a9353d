#pragma once

#include <vector>

#include "drivers/measurement/camera_frame.hpp"

namespace infuse::features {

/// One quantity of an image: width × height floats, rows from the top.
struct Plane {
  int width = 0;   ///< samples
  int height = 0;  ///< samples
  int step = 1;    ///< pixels between samples; sample (0, 0) is pixel (0, 0)
  std::vector<float> values;

  /// Makes this plane as large as another one; keeps its memory.
  void resize_like(const Plane& other);
  /// Row `v`; rows beyond the border are those of the border.
  const float* row(int v) const;
  float* row(int v);
};

/// Grey levels (whole numbers 0 … 255) of a kGrey8 or kBgr8 frame, ITU-R BT.601.
Plane grey_plane(const CameraFrame& frame);

/// Grey levels, 0 … 255, of a kGrey8 frame reduced by means of `step` × `step` pixels; what is left
/// over at the right and lower border is dropped. The sample size becomes the plane's pixel
/// (`Plane::step` is 1). Keeps the memory of `plane`.
void reduce_by_means(const CameraFrame& grey, int step, Plane& plane);

/// Gaussian blur that keeps its memory.
class Blur {
 public:
  /// Smooths `plane` by a Gaussian of `sigma` pixels (0: unchanged), borders replicated, and thins
  /// it to samples `step` pixels apart, a multiple of the plane's own. `out` is another plane.
  void compute(const Plane& plane, double sigma, int step, Plane& out);

 private:
  std::vector<float> kernel_, line_;
};

/// The same as a new plane.
Plane blurred(const Plane& plane, double sigma, int step = 1);

}  // namespace infuse::features
