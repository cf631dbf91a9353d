#pragma once

#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "fusion/calibration/ring_directions.hpp"

namespace infuse::calibration {

/// One quantity of a picture: width × height floats in 0 … 1, rows from the top.
struct Plane {
  int width = 0;   ///< samples
  int height = 0;  ///< samples
  int step = 1;    ///< pixels between samples; sample (0, 0) is pixel (0, 0)
  std::vector<float> values;
};

/// Grey levels (whole numbers 0 … 255) of a kGrey8 or kBgr8 frame, ITU-R BT.601.
Plane grey_plane(const CameraFrame& frame);

/// Edge strength after Levinson and Thrun, I 4.3.1.4:
///   e(u, v) = max over the eight neighbours of |I(u, v) − I(u', v')|,
/// 0 … 255 for grey levels; at the border over the neighbours that exist.
Plane edge_strength(const Plane& grey);

/// How much grey changes along the lidar's rings: |n · ∇I|, n the ring's direction and ∇I Sobel's
/// derivatives, 0 … 255 for grey levels, borders replicated. A return has an edge where its
/// neighbours *on its ring* lie farther (I 3.6), and a ring does not see the edges that it runs
/// along: kerbs, eaves and the horizon are edges of the picture that the lidar has none for, and
/// drew the measure to themselves by up to a degree. Sobel's smoothing also hears less noise than
/// the largest step to a neighbour does.
Plane ring_edge(const Plane& grey, const RingDirections& rings);

/// The plane of whole numbers 0 … 255 with every value replaced by its rank among all, divided by
/// their number: 0 ≤ … < 1, equal values share the mean of their ranks.
Plane equalized(Plane plane);

/// Every value of the plane against its surroundings: (g − m) / s, m and s mean and standard
/// deviation under a Gaussian of `width` pixels, brought to 0 … 1 by ½ + ½ z / √(1 + z²). `floor`
/// (the values' unit) is added to s² as its square, so that noise on a smooth surface stays small.
/// Takes out light that changes slowly over the picture (shadow and sun, haze, vignetting, walls
/// that get darker upwards), which goes with where things are and not with what they are.
Plane normalize_local_contrast(const Plane& plane, double width, double noise_sigma);

/// The plane smoothed by a Gaussian of `sigma` pixels (0: unchanged), borders replicated, and then
/// thinned to samples `step` pixels apart, a multiple of the plane's own.
Plane blurred(const Plane& plane, double sigma, int step = 1);

}  // namespace infuse::calibration
