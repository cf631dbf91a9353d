#include "fusion/calibration/objective.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <stdexcept>

#include "drivers/measurement/median.hpp"
#include "drivers/measurement/simd.hpp"
#include "fusion/dependence/joint_histogram.hpp"
#include "fusion/features/ranks.hpp"
#include "fusion/geometry/plane_length.hpp"
#include "fusion/geometry/pose_gradient.hpp"

namespace infuse::calibration {
namespace {

/// Plane in the form that the look-up needs.
struct Samples2d {
  const CompactPlane::Sample* values;
  int width;
  float right, bottom;  // last position with a sample after it
  float scale;          // samples per pixel
};

/// Neighbours in a row, read at once: half as many reads, which dominate a look-up's time.
struct Neighbours {
  CompactPlane::Sample left, right;
};

Neighbours neighbours(const CompactPlane::Sample* at) {
  Neighbours both;
  std::memcpy(&both, at, sizeof both);
  return both;
}

/// Bilinear look-up of one block of points, I 4.3.1.4, with its derivatives by the pixel. Outside
/// the image: the border's value, without a derivative across it. Points that the camera does not
/// see and points whose `lidar` is not compared are absent.
INFUSE_SIMD_CLONES void look_up_block(const Samples2d plane, const float* __restrict lidar,
                                      const float* __restrict u, const float* __restrict v,
                                      size_t count, float* __restrict value, float* __restrict by_u,
                                      float* __restrict by_v) {
  constexpr size_t kGroup = 64;  // points in the first-level cache
  int at[kGroup];
  float a[kGroup], b[kGroup];
  Neighbours upper[kGroup], lower[kGroup];
  for (size_t first = 0; first < count; first += kGroup) {
    const size_t n = std::min(kGroup, count - first);
    for (size_t k = 0; k < n; ++k) {
      const size_t i = first + k;
      const bool absent = (u[i] != u[i]) | (lidar[i] != lidar[i]);
      const float su = absent ? 0.0F : u[i] * plane.scale;
      const float sv = absent ? 0.0F : v[i] * plane.scale;
      const float low_u = su > 0.0F ? su : 0.0F;
      const float low_v = sv > 0.0F ? sv : 0.0F;
      const float cu = low_u < plane.right ? low_u : plane.right;
      const float cv = low_v < plane.bottom ? low_v : plane.bottom;
      const int iu = static_cast<int>(cu);
      const int iv = static_cast<int>(cv);
      a[k] = cu - static_cast<float>(iu);
      b[k] = cv - static_cast<float>(iv);
      at[k] = iv * plane.width + iu;
      by_u[i] = (absent | (cu != su)) ? 0.0F : plane.scale;
      by_v[i] = (absent | (cv != sv)) ? 0.0F : plane.scale;
      value[i] = absent ? dependence::kAbsent : 0.0F;
    }
    for (size_t k = 0; k < n; ++k) {
      upper[k] = neighbours(plane.values + at[k]);
      lower[k] = neighbours(plane.values + at[k] + plane.width);
    }
    for (size_t k = 0; k < n; ++k) {
      const size_t i = first + k;
      const float upper_left = static_cast<float>(upper[k].left);
      const float lower_left = static_cast<float>(lower[k].left);
      const float upper_change = static_cast<float>(upper[k].right) - upper_left;
      const float lower_change = static_cast<float>(lower[k].right) - lower_left;
      const float above = upper_left + a[k] * upper_change;
      const float down = lower_left + a[k] * lower_change - above;
      const float along = (1 - b[k]) * upper_change + b[k] * lower_change;
      value[i] += CompactPlane::kUnit * (above + b[k] * down);  // kAbsent stays what it is
      by_u[i] *= CompactPlane::kUnit * along;
      by_v[i] *= CompactPlane::kUnit * down;
    }
  }
}

template <class T>
std::span<T> part(std::vector<std::remove_const_t<T>>& all, const VisiblePoints::Block& block) {
  return std::span<T>(all).subspan(block.begin, block.end - block.begin);
}

geometry::PointsView block_points(const VisiblePoints& points, const VisiblePoints::Block& block) {
  const auto cut = [&](const std::vector<float>& all) {
    return std::span<const float>(all).subspan(block.begin, block.end - block.begin);
  };
  return {cut(points.x), cut(points.y), cut(points.z)};
}

/// A perturbation of T_camera_lidar by one of T_refcam_lidar; the camera's model is its own.
SceneInformation pose_adjoint(const RigCamera& camera) {
  SceneInformation adjoint = SceneInformation::Identity();
  adjoint.topLeftCorner<6, 6>() = geometry::adjoint(camera.T_camera_refcam);
  return adjoint;
}

constexpr float kNearestBand = 8;  // m; further ones are twice as deep each (decision 018)

/// Band of depths in which a point lies.
size_t depth_band(float depth) {
  size_t band = 0;
  for (float limit = kNearestBand; depth > limit && band + 1 < kDepthBands; limit *= 2) ++band;
  return band;
}

}  // namespace

SceneInformation total_information(std::span<const SceneInformation> scenes) {
  return std::accumulate(scenes.begin(), scenes.end(), SceneInformation::Zero().eval());
}

PerImageFeature<bool> compared_image_features(std::span<const TermOptions> terms) {
  PerImageFeature<bool> compared{};
  for (const TermOptions& term : terms) {
    for (const ImageFeature feature : term.image) compared[index(feature)] = true;
  }
  return compared;
}

BlurredImages::BlurredImages(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                             std::span<const TermOptions> terms, const ImageBlur& blur) {
  const PerImageFeature<bool> compared = compared_image_features(terms);
  for (const Scene& scene : scenes) {
    const double sigma = blur.sigma(cameras[scene.camera]);
    images_.push_back(scene.blurred != nullptr
                          ? scene.blurred->at(sigma)
                          : SceneImages(scene.image, compared, std::span(&sigma, 1)).at(sigma));
    if (images_.back() == nullptr) throw std::logic_error("a scene is not prepared for this blur");
  }
}

BlurredImages BlurredImages::permuted(std::span<const size_t> source_scenes) const {
  std::vector<SceneImages::Level> other;
  for (const size_t scene : source_scenes) other.push_back(images_[scene]);
  return BlurredImages(std::move(other));
}

Objective::Objective(const VisiblePoints& points, const BlurredImages& images,
                     std::span<const RigCamera> cameras, std::span<const Scene> scenes,
                     std::span<const TermOptions> terms)
    : points_(points), images_(&images), cameras_(cameras), scenes_(scenes) {
  size_t max_features = 1;
  for (const TermOptions& term : terms) {
    terms_.push_back({term, make_term(term, points)});
    max_features = std::max(max_features, term.image.size());
  }
  for (auto* scratch : {&u_, &v_, &depth_, &by_u_, &by_v_}) scratch->resize(points.size());
  for (auto* scratch : {&value_, &value_by_u_, &value_by_v_, &by_value_}) {
    scratch->resize(max_features * points.size());
  }
}

void Objective::project(const Eigen::Isometry3d& T_refcam_lidar) {
  for (const VisiblePoints::Block& block : points_.blocks) {
    const RigCamera& camera = cameras_[scenes_[block.scene].camera];
    geometry::project_points(
        camera.model, camera.T_camera_refcam * T_refcam_lidar, block_points(points_, block),
        {part<float>(u_, block), part<float>(v_, block), part<float>(depth_, block)});
  }
}

void Objective::look_up(const TermOptions& term) {
  // With a single lidar feature, points that are not compared need no look-up.
  const std::vector<float>& compared =
      term.lidar.size() == 1 ? points_.lidar[index(term.lidar.front())] : points_.x;
  for (size_t f = 0; f < term.image.size(); ++f) {
    for (const VisiblePoints::Block& block : points_.blocks) {
      const CompactPlane& plane = images_->plane(block.scene, term.image[f]);
      const size_t from = block.begin;
      const size_t to = f * points_.size() + block.begin;
      look_up_block({.values = plane.values.data(),
                     .width = plane.width,
                     .right = static_cast<float>(plane.width - 1) - 1e-3F,
                     .bottom = static_cast<float>(plane.height - 1) - 1e-3F,
                     .scale = 1.0F / static_cast<float>(plane.step)},
                    &compared[from], &u_[from], &v_[from], block.end - from, &value_[to],
                    &value_by_u_[to], &value_by_v_[to]);
    }
  }
}

dependence::Estimate Objective::differentiate_pixels(const Eigen::Isometry3d& T_refcam_lidar,
                                                     bool with_gradient, bool per_sample) {
  ++evaluations_;
  dependence::Estimate sum;
  if (points_.size() == 0) return {.value = 0, .reason = "no lidar point lies in an image"};
  project(T_refcam_lidar);
  if (with_gradient) {
    std::fill(by_u_.begin(), by_u_.end(), 0.0F);
    std::fill(by_v_.begin(), by_v_.end(), 0.0F);
  }
  for (Term& term : terms_) {
    look_up(term.options);
    const size_t values = term.options.image.size() * points_.size();
    const dependence::Estimate one = term.dependence->evaluate(
        std::span(value_).first(values),
        with_gradient ? std::span(by_value_).first(values) : std::span<float>());
    sum.value += term.options.weight * one.value;
    if (!one.usable()) sum.reason = one.reason;
    if (!with_gradient) continue;
    const auto weight = static_cast<float>(
        term.options.weight *
        (per_sample ? static_cast<double>(term.dependence->sample_count()) : 1.0));
    for (size_t first = 0; first < values; first += points_.size()) {
      for (size_t i = 0; i < by_u_.size(); ++i) {
        by_u_[i] += weight * by_value_[first + i] * value_by_u_[first + i];
        by_v_[i] += weight * by_value_[first + i] * value_by_v_[first + i];
      }
    }
  }
  return sum;
}

geometry::Vector6 Objective::block_gradient(const VisiblePoints::Block& block,
                                            const Eigen::Isometry3d& T_refcam_lidar) const {
  const RigCamera& camera = cameras_[scenes_[block.scene].camera];
  const std::span<const float> by_u =
      std::span(by_u_).subspan(block.begin, block.end - block.begin);
  const std::span<const float> by_v =
      std::span(by_v_).subspan(block.begin, block.end - block.begin);
  const geometry::Vector6 camera_gradient =
      geometry::pose_gradient(camera.model, camera.T_camera_refcam * T_refcam_lidar,
                              block_points(points_, block), by_u, by_v);
  // T_camera_refcam exp(ξ) = exp(Ad ξ) T_camera_refcam.
  return geometry::adjoint(camera.T_camera_refcam).transpose() * camera_gradient;
}

Evaluation Objective::evaluate(const Eigen::Isometry3d& T_refcam_lidar, bool with_gradient) {
  Evaluation evaluation{.estimate = differentiate_pixels(T_refcam_lidar, with_gradient)};
  if (!with_gradient || points_.size() == 0) return evaluation;
  for (const VisiblePoints::Block& block : points_.blocks) {
    evaluation.gradient += block_gradient(block, T_refcam_lidar);
  }
  return evaluation;
}

Eigen::Matrix<double, 2, 4> Objective::pixel_by_camera(const CameraIntrinsics& camera, size_t i,
                                                       const Eigen::Vector3d& p) const {
  // Without distortion the point is at r · direction; k1 moves it outwards by r³.
  double r3 = 0;  // divided by the point's distance from the axis
  if (camera.model == CameraIntrinsics::Model::kPinhole) {
    r3 = (p.x() * p.x() + p.y() * p.y()) / (p.z() * p.z() * p.z());
  } else if (const double radius = geometry::plane_length(p.x(), p.y()); radius > 0) {
    const double r = std::atan2(radius, p.z());
    r3 = r * r * r / radius;
  }
  Eigen::Matrix<double, 2, 4> by;
  by << u_[i] - camera.cx, 1, 0, r3 * camera.fx * p.x(),  //
      v_[i] - camera.cy, 0, 1, r3 * camera.fy * p.y();
  return by;
}

Eigen::Vector4d Objective::camera_gradient(const VisiblePoints::Block& block,
                                           const Eigen::Isometry3d& T_refcam_lidar) const {
  const RigCamera& camera = cameras_[scenes_[block.scene].camera];
  const Eigen::Isometry3d T = camera.T_camera_refcam * T_refcam_lidar;
  Eigen::Vector4d gradient = Eigen::Vector4d::Zero();
  for (size_t i = block.begin; i < block.end; ++i) {
    const Eigen::Vector2d by_pixel(by_u_[i], by_v_[i]);
    if (by_pixel.isZero(0)) continue;
    const Eigen::Vector3d p = T * Eigen::Vector3d(points_.x[i], points_.y[i], points_.z[i]);
    gradient += pixel_by_camera(camera.model.intrinsics(), i, p).transpose() * by_pixel;
  }
  return gradient;
}

std::vector<SceneGradient> Objective::scene_gradients(const Eigen::Isometry3d& T_refcam_lidar,
                                                      dependence::Estimate* estimate) {
  std::vector<SceneGradient> pulls(scenes_.size(), SceneGradient::Zero());
  const dependence::Estimate sum = differentiate_pixels(T_refcam_lidar, true);
  if (estimate != nullptr) *estimate = sum;
  for (const VisiblePoints::Block& block : points_.blocks) {
    pulls[block.scene].head<6>() += block_gradient(block, T_refcam_lidar);
    pulls[block.scene].tail<4>() += camera_gradient(block, T_refcam_lidar);
  }
  return pulls;
}

Objective::Samples Objective::samples(const Eigen::Isometry3d& T_refcam_lidar, size_t term) {
  const TermOptions& options = terms_[term].options;
  project(T_refcam_lidar);
  look_up(options);
  const std::vector<float>& lidar = points_.lidar[index(options.lidar.front())];
  Samples samples;
  for (const uint32_t i : select_term_points(options, points_)) {
    samples.lidar.push_back(lidar[i]);
    samples.image.push_back(value_[i]);
  }
  if (options.equalize) features::equalize(samples.lidar);
  return samples;
}

double Objective::median_range() const {
  std::vector<double> ranges;
  for (size_t i = 0; i < points_.size(); ++i) {
    ranges.push_back(Eigen::Vector3d(points_.x[i], points_.y[i], points_.z[i]).norm());
  }
  if (ranges.empty()) return 0;
  return median(ranges);
}

PointInformation Objective::information(const Eigen::Isometry3d& T_refcam_lidar) {
  constexpr auto kColumns = static_cast<Eigen::Index>(2 * kDepthBands);
  PointInformation all;
  all.scenes.assign(scenes_.size(), SceneInformation::Zero());
  all.bias.setZero(10, kColumns * static_cast<Eigen::Index>(cameras_.size()));
  differentiate_pixels(T_refcam_lidar, true, true);
  for (const VisiblePoints::Block& block : points_.blocks) {
    const size_t index = scenes_[block.scene].camera;
    const RigCamera& camera = cameras_[index];
    const Eigen::Isometry3d T = camera.T_camera_refcam * T_refcam_lidar;
    SceneInformation scene = SceneInformation::Zero();
    Eigen::Matrix<double, 10, kColumns> bias = Eigen::Matrix<double, 10, kColumns>::Zero();
    for (size_t i = block.begin; i < block.end; ++i) {
      const Eigen::Vector2d by_pixel(by_u_[i], by_v_[i]);
      if (by_pixel.isZero(0)) continue;
      const Eigen::Vector3d p = T * Eigen::Vector3d(points_.x[i], points_.y[i], points_.z[i]);
      const auto at = camera.model.project_with_derivatives(p);
      if (!at) continue;
      SceneGradient score;
      score << at->by_pose.transpose() * by_pixel,
          pixel_by_camera(camera.model.intrinsics(), i, p).transpose() * by_pixel;
      scene.noalias() += score * score.transpose();
      bias.middleCols<2>(static_cast<Eigen::Index>(2 * depth_band(depth_[i]))) +=
          score * by_pixel.transpose();
    }
    const SceneInformation adjoint = pose_adjoint(camera);
    all.scenes[block.scene] += adjoint.transpose() * scene * adjoint;
    all.bias.middleCols<kColumns>(static_cast<Eigen::Index>(index) * kColumns) +=
        adjoint.transpose() * bias;
  }
  return all;
}

}  // namespace infuse::calibration
