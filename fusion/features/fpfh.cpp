#include "fusion/features/fpfh.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "fusion/features/neighbour_search.hpp"

namespace infuse::features {
namespace {

constexpr float kMaxCoordinate = 1e5F;  // m; no measurement, and single precision has centimetres

/// Points by coordinate, for the search.
struct Cloud {
  std::vector<Eigen::Vector3f> points;
  std::vector<float> x, y, z;

  void add(const Eigen::Vector3f& p) {
    points.push_back(p);
    x.push_back(p.x()), y.push_back(p.y()), z.push_back(p.z());
  }
};

/// Nearest points within a radius, nearest first. The point itself is one of them.
class Neighbourhood {
 public:
  Neighbourhood(const Cloud& cloud, int capacity)
      : indices_(static_cast<size_t>(capacity)), squares_(indices_.size()) {
    search_.build({cloud.x, cloud.y, cloud.z});
  }

  std::span<const int32_t> find(const Eigen::Vector3f& point, double radius) {
    const auto square = static_cast<float>(radius * radius);
    return {indices_.data(), search_.nearest_points(point.data(), square, indices_, squares_)};
  }

 private:
  NeighbourSearch search_;
  std::vector<int32_t> indices_;
  std::vector<float> squares_;
};

/// Normal of the plane through the points, facing the origin.
Eigen::Vector3f plane_normal(const Cloud& cloud, std::span<const int32_t> members) {
  const Eigen::Vector3f first = cloud.points[static_cast<size_t>(members.front())];
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const int32_t i : members) {
    const Eigen::Vector3d p = (cloud.points[static_cast<size_t>(i)] - first).cast<double>();
    mean += p;
    squares += p * p.transpose();
  }
  const auto n = static_cast<double>(members.size());
  mean /= n;
  // The iterative solver needs no trigonometric functions, whose last bits differ by processor.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread(squares / n -
                                                              mean * mean.transpose());
  const Eigen::Vector3f normal = spread.eigenvectors().col(0).cast<float>();
  return normal.dot(first) > 0 ? (-normal).eval() : normal;
}

/// Angle of (x, y) within 2e-4 rad, from additions, multiplications and one division: same bytes on
/// every processor.
float angle_of(float y, float x) {
  const float a = std::abs(x), b = std::abs(y);
  const float t = std::min(a, b) / std::max({a, b, 1e-30F});
  const float s = t * t;
  // Abramowitz and Stegun (4.4.49) shortened.
  float angle =
      t * (0.9998660F + s * (-0.3302995F + s * (0.1801410F + s * (-0.0851330F + s * 0.0208351F))));
  if (b > a) angle = std::numbers::pi_v<float> / 2 - angle;
  if (x < 0) angle = std::numbers::pi_v<float> - angle;
  return y < 0 ? -angle : angle;
}

/// Bin of a value between `low` and `high`.
size_t bin_of(float value, float low, float high) {
  const float position = static_cast<float>(kFpfhBins) * (value - low) / (high - low);
  return static_cast<size_t>(std::clamp(position, 0.0F, static_cast<float>(kFpfhBins) - 0.5F));
}

/// Adds the three angles of a pair of points to the histograms. The point whose normal is nearer to
/// the line between them is the source, so that the order of the two does not matter.
void add_pair(const Eigen::Vector3f& from, const Eigen::Vector3f& from_normal,
              const Eigen::Vector3f& to, const Eigen::Vector3f& to_normal, Fpfh& histograms) {
  Eigen::Vector3f line = to - from;
  const float distance = line.norm();
  if (!(distance > 0)) return;
  line /= distance;
  const float from_cosine = from_normal.dot(line), to_cosine = to_normal.dot(line);
  const bool swapped = std::abs(from_cosine) < std::abs(to_cosine);
  const Eigen::Vector3f& u = swapped ? to_normal : from_normal;
  const Eigen::Vector3f& other = swapped ? from_normal : to_normal;
  if (swapped) line = -line;
  Eigen::Vector3f v = line.cross(u);
  const float length = v.norm();
  if (!(length > 1e-6F)) return;
  v /= length;
  const Eigen::Vector3f w = u.cross(v);
  constexpr float kPi = std::numbers::pi_v<float>;
  histograms[bin_of(v.dot(other), -1, 1)] += 1;
  histograms[kFpfhBins + bin_of(swapped ? -to_cosine : from_cosine, -1, 1)] += 1;
  histograms[2 * kFpfhBins + bin_of(angle_of(w.dot(other), u.dot(other)), -kPi, kPi)] += 1;
}

/// Scales each of the three histograms to a sum of 100.
void normalise(Fpfh& histograms) {
  for (size_t part = 0; part < 3; ++part) {
    const auto begin = histograms.begin() + static_cast<std::ptrdiff_t>(part * kFpfhBins);
    float sum = 0;
    std::for_each_n(begin, kFpfhBins, [&](float count) { sum += count; });
    if (sum > 0) std::for_each_n(begin, kFpfhBins, [&](float& count) { count *= 100 / sum; });
  }
}

}  // namespace

std::optional<std::string> FpfhOptions::invalid() const {
  if (!(normal_radius > 0 && normal_radius <= 100))
    return "normal_radius must be between 0 and 100";
  if (!(feature_radius > 0 && feature_radius <= 100))
    return "feature_radius must be between 0 and 100";
  if (min_neighbours < 3) return "min_neighbours must be at least 3";
  if (max_neighbours < min_neighbours || max_neighbours > 10'000) {
    return "max_neighbours must be between min_neighbours and 10000";
  }
  return std::nullopt;
}

FpfhCloud compute_fpfh(std::span<const Eigen::Vector3f> points, const FpfhOptions& options) {
  FpfhCloud out;
  out.has_feature.assign(points.size(), 0);
  out.normals.assign(points.size(), Eigen::Vector3f::Zero());
  out.features.assign(points.size(), Fpfh{});

  Cloud cloud;
  std::vector<uint32_t> origin;  // index in `points` of each point of the cloud
  for (size_t i = 0; i < points.size(); ++i) {
    // Written so that NaN is left out.
    if (!(points[i].cwiseAbs().maxCoeff() < kMaxCoordinate) || points[i].hasNaN()) continue;
    cloud.add(points[i]);
    origin.push_back(static_cast<uint32_t>(i));
  }
  const auto least = static_cast<size_t>(options.min_neighbours);
  if (cloud.points.size() < least) return out;
  Neighbourhood neighbourhood(cloud, options.max_neighbours);

  const size_t size = cloud.points.size();
  std::vector<uint8_t> has_normal(size, 0);
  std::vector<Eigen::Vector3f> normals(size);
  for (size_t i = 0; i < size; ++i) {
    const auto members = neighbourhood.find(cloud.points[i], options.normal_radius);
    if (members.size() < least) continue;
    normals[i] = plane_normal(cloud, members);
    has_normal[i] = 1;
    out.normals[origin[i]] = normals[i];
  }

  // Neighbours with a normal, point after point, and each point's own histogram of pairs.
  std::vector<uint32_t> neighbours;
  std::vector<size_t> first(size + 1, 0);
  std::vector<Fpfh> own(size, Fpfh{});
  for (size_t i = 0; i < size; ++i) {
    if (has_normal[i] != 0) {
      for (const int32_t found : neighbourhood.find(cloud.points[i], options.feature_radius)) {
        const auto k = static_cast<uint32_t>(found);
        if (k == i || has_normal[k] == 0) continue;
        neighbours.push_back(k);
        add_pair(cloud.points[i], normals[i], cloud.points[k], normals[k], own[i]);
      }
      normalise(own[i]);
    }
    first[i + 1] = neighbours.size();
  }

  for (size_t i = 0; i < size; ++i) {
    const size_t count = first[i + 1] - first[i];
    if (count < least) continue;
    Fpfh sum = {};
    for (size_t n = first[i]; n < first[i + 1]; ++n) {
      const uint32_t k = neighbours[n];
      const float distance = (cloud.points[k] - cloud.points[i]).norm();
      if (!(distance > 0)) continue;
      for (size_t bin = 0; bin < sum.size(); ++bin) sum[bin] += own[k][bin] / distance;
    }
    for (size_t bin = 0; bin < sum.size(); ++bin) {
      sum[bin] = own[i][bin] + sum[bin] / static_cast<float>(count);
    }
    normalise(sum);
    out.features[origin[i]] = sum;
    out.has_feature[origin[i]] = 1;
  }
  return out;
}

}  // namespace infuse::features
