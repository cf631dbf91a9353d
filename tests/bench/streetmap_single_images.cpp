#include <chrono>
#include <cmath>

#include "drivers/measurement/angles.hpp"
#include "tests/bench/streetmap_sections.hpp"
#include "tests/study/streetmap/single_image_pose.hpp"

namespace infuse::streetmap::bench {
namespace {

struct Moments {
  double n = 0, sum = 0, squares = 0;
  void add(double x) {
    ++n;
    sum += x;
    squares += x * x;
  }
  double mean() const { return n > 0 ? sum / n : 0; }
  double sigma() const {
    return n > 0 ? std::sqrt(std::max(squares / n - mean() * mean(), 0.0)) : 0;
  }
};

struct ImageRow {
  Moments across, turned, seconds;
};

ImageRow locate_all(const SegmentMap& map, const std::vector<PosedImage>& posed_images,
                    const CameraMount& mount, int step, const SingleImageOptions& options) {
  const geometry::CameraModel camera(mount.intrinsics);
  ImageRow row;
  uint64_t draws = 1;
  for (const PosedImage& posed_image : posed_images) {
    ImageFeatures features;
    if (!extract_features(posed_image.image, step, features)) continue;
    // The error of the prior is up to half of the search range.
    const auto uniform = [&] {
      draws = draws * 6364136223846793005ULL + 1442695040888963407ULL;
      return static_cast<double>(draws >> 40) / (1 << 23) - 1;
    };
    const double lateral_offset = uniform(), yaw_offset = 10 * kDegree * uniform();
    const auto begin = std::chrono::steady_clock::now();
    const SingleImagePose pose =
        locate_from_image(map, features, camera, mount.T_camera_lidar,
                          posed_image.truth.compose({0, lateral_offset, yaw_offset}), options);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    if (!pose.usable()) continue;
    const PlanarPose found = posed_image.truth.compose({0, lateral_offset, yaw_offset})
                                 .compose({0, pose.lateral, pose.yaw});
    const PlanarPose error = posed_image.truth.motion_to(found);
    row.across.add(std::abs(error.y));
    row.turned.add(std::abs(error.yaw) / kDegree);
    row.seconds.add(elapsed.count() / static_cast<double>(pose.scores.size()));
  }
  return row;
}

}  // namespace

bool one_image(std::ostream& out, int images) {
  if (!render("street")) return false;
  CameraMount mount;
  const std::vector<PosedImage> posed_images = read_posed_images("street", images, mount);
  const DriveMap made = make_map("street");
  out << "The drive `street` (fixtures/scenarios/online_2hz.toml): " << posed_images.size()
      << " images, reduced by 8; mean ± standard deviation of the error; time per\n"
      << "pose relative to LSMI, one thread.\n\n"
      << "| measure | lateral, m | heading, ° | time per pose | images |\n|---|---|---|---|---|\n";
  double unit = 0;
  for (const ImageMeasure measure :
       {ImageMeasure::kLsmi, ImageMeasure::kBlsmi, ImageMeasure::kMi, ImageMeasure::kQmi,
        ImageMeasure::kSce, ImageMeasure::kCorrelation, ImageMeasure::kBoundaries}) {
    SingleImageOptions options;
    options.measure = measure;
    // Slow measures use fewer pixels, or the table would take an hour.
    if (measure == ImageMeasure::kMi || measure == ImageMeasure::kCorrelation) {
      options.max_samples = 200;
    }
    if (measure == ImageMeasure::kMi) options.fit.centres = 20;
    if (measure == ImageMeasure::kMi) options.fit.sigmas = {1.0};
    const ImageRow row = locate_all(made.map, posed_images, mount, 8, options);
    if (measure == ImageMeasure::kLsmi) unit = row.seconds.mean();
    out << format_text("| %s | %.2f ± %.2f | %.1f ± %.1f | %.2f | %.0f |\n", name_of(measure),
                       row.across.mean(), row.across.sigma(), row.turned.mean(), row.turned.sigma(),
                       row.seconds.mean() / unit, row.across.n);
    std::fprintf(stderr, "%s: %.2f m\n", name_of(measure), row.across.mean());
  }
  out << "\nMLMI and dCor use 200 pixels, the others 1500; MLMI uses one kernel width.\n\n"
      << "| reduced by (LSMI) | lateral, m | heading, ° |\n|---|---|---|\n";
  for (const int step : {2, 4, 8, 16, 24}) {
    const ImageRow row = locate_all(made.map, posed_images, mount, step, {});
    out << format_text("| %d | %.2f ± %.2f | %.1f ± %.1f |\n", step, row.across.mean(),
                       row.across.sigma(), row.turned.mean(), row.turned.sigma());
  }
  return true;
}

}  // namespace infuse::streetmap::bench
