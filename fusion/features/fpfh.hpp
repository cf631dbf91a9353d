#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace infuse::features {

/// Number of bins of each of the three angles of a pair of points, as the Point Cloud Library's
/// implementation of Rusu, Blodow and Beetz 2009.
inline constexpr size_t kFpfhBins = 11;

/// Fast point feature histogram: three histograms (alpha, phi, theta), each of which sums to 100.
using Fpfh = std::array<float, 3 * kFpfhBins>;

/// m, side of the grid of the points that the defaults suit.
inline constexpr double kFpfhGrid = 0.5;

/// Settings of fast point feature histograms.
struct FpfhOptions {
  double normal_radius = 3 * kFpfhGrid;   ///< m, neighbourhood that a plane is fitted to
  double feature_radius = 5 * kFpfhGrid;  ///< m, neighbourhood of the histograms
  int max_neighbours = 100;  ///< of both neighbourhoods, the nearest: bounds the time where points
                             ///< are dense
  int min_neighbours = 6;    ///< points with fewer neighbours have neither normal nor histogram

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Histograms of a cloud, one entry per point in each array.
struct FpfhCloud {
  std::vector<uint8_t> has_feature;      ///< 0: too few neighbours, or not a finite point
  std::vector<Eigen::Vector3f> normals;  ///< unit length, facing the origin; zero where unknown
  std::vector<Fpfh> features;            ///< zero where there is none
};

/// Computes the fast point feature histograms of points (m, lidar frame): R. B. Rusu, N. Blodow,
/// M. Beetz, Fast point feature histograms (FPFH) for 3D registration, ICRA 2009; P 4.4.1. The
/// weight of a neighbour's histogram is the inverse of its distance. Points are best on a grid,
/// because a histogram counts points, and so depends on how dense they are.
///
/// Independent of the pose of the cloud but for rounding. Same bytes on every processor.
FpfhCloud compute_fpfh(std::span<const Eigen::Vector3f> points, const FpfhOptions& options = {});

}  // namespace infuse::features
