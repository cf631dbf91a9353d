#include "daemon/tools/calibrate_intrinsics/intrinsics_format.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "daemon/protocol/number_json.hpp"
#include "drivers/measurement/angles.hpp"

namespace infuse::daemon {
namespace {

using target::IntrinsicsResult;

constexpr int kFirstRadial = 4;  // k1 among the numbers of the intrinsics

const char* model_name(const CameraIntrinsics& camera) {
  return camera.model == CameraIntrinsics::Model::kPinhole ? "pinhole" : "fisheye";
}

Json coverage_json(const target::ImageCoverage& coverage) {
  return {{"share", coverage.share},
          {"radius_px", coverage.radius},
          {"corner_radius_px", coverage.corner_radius},
          {"empty_parts", coverage.empty_parts}};
}

std::string numbers_text(const IntrinsicsResult& result) {
  std::string text;
  const auto numbers = target::to_vector(result.camera);
  const auto names = target::intrinsics_names(result.camera.model);
  for (int k = 0; k < static_cast<int>(names.size()); ++k) {
    const char* name = names[static_cast<size_t>(k)];
    text += k < kFirstRadial
                ? fmt::format("  {}  {:9.2f} ± {:.2f} px\n", name, numbers(k), result.sigma(k))
                : fmt::format("  {}  {:9.5f} ± {:.5f}\n", name, numbers(k), result.sigma(k));
  }
  return text;
}

std::string views_text(const BoardImages& images, const IntrinsicsResult& result) {
  std::string text;
  for (size_t v = 0; v < result.views.size(); ++v) {
    const target::IntrinsicsView& view = result.views[v];
    text += fmt::format("  {:<28} ", images.names[v]);
    if (view.residual.size() == 0) {
      text += "no pose of the board fits\n";
      continue;
    }
    text += fmt::format("{:5.2f} px{}\n", view.rms, view.used ? "" : ": outlier, not used");
  }
  constexpr size_t kMaxNotes = 5;
  for (size_t i = 0; i < std::min(images.skipped.size(), kMaxNotes); ++i)
    text += "  skipped: " + images.skipped[i] + "\n";
  if (images.skipped.size() > kMaxNotes)
    text += fmt::format("  and {} more were skipped\n", images.skipped.size() - kMaxNotes);
  return text;
}

}  // namespace

Json to_json(const BoardImages& images, const IntrinsicsResult& result) {
  Json views = Json::array();
  for (size_t v = 0; v < result.views.size(); ++v) {
    views.push_back({{"name", images.names[v]}, {"used", result.views[v].used}});
    if (result.views[v].residual.size() > 0) views.back()["rms_px"] = result.views[v].rms;
  }
  Json json = {{"usable", result.usable()},
               {"images", images.images},
               {"views_used", result.used},
               {"views", std::move(views)},
               {"skipped", images.skipped}};
  if (!images.camera.empty()) json["camera"] = images.camera;
  if (!result.usable()) json["reason"] = result.reason;
  if (result.covariance.size() == 0) return json;
  const CameraIntrinsics& camera = result.camera;
  const auto numbers = target::to_vector(camera);
  const auto names = target::intrinsics_names(camera.model);
  Json distortion = Json::array(), sigma;
  for (int k = 0; k < static_cast<int>(names.size()); ++k) {
    if (k >= kFirstRadial) distortion.push_back(numbers(k));
    sigma[names[static_cast<size_t>(k)]] = result.sigma(k);
  }
  json["intrinsics"] = {{"model", model_name(camera)},
                        {"width", camera.width},
                        {"height", camera.height},
                        {"fx", camera.fx},
                        {"fy", camera.fy},
                        {"cx", camera.cx},
                        {"cy", camera.cy},
                        {"distortion", std::move(distortion)},
                        {"sigma", std::move(sigma)},
                        {"covariance", rows_json(result.covariance)}};
  json["rms_px"] = result.rms;
  json["corner_noise_px"] = result.corner_noise;
  json["view_ratio"] = result.view_ratio;
  json["board_bow_m"] = result.bow;
  json["tilt_spread_deg"] = result.tilt_spread / kDegree;
  json["coverage"] = coverage_json(result.coverage);
  return json;
}

std::string describe_coverage(const IntrinsicsResult& result) {
  const target::ImageCoverage& coverage = result.coverage;
  std::string text;
  if (!coverage.empty_parts.empty()) text += "no corners in the image's " + coverage.empty_parts;
  // A cell of the coverage is what corners reach beyond their own place.
  const double cell = static_cast<double>(result.camera.width) / target::ImageCoverage::kColumns;
  if (coverage.radius + cell < coverage.corner_radius) {
    text += fmt::format(
        "{}distortion beyond {:.0f} px of the centre is not determined (the image reaches {:.0f})",
        text.empty() ? "" : "; ", coverage.radius, coverage.corner_radius);
  }
  return text;
}

IntrinsicsSigma stated_sigma(const IntrinsicsResult& result) {
  return {std::max(result.sigma(0) / result.camera.fx, result.sigma(1) / result.camera.fy),
          std::max(result.sigma(2), result.sigma(3)), result.sigma(kFirstRadial)};
}

std::string to_text(const BoardImages& images, const IntrinsicsResult& result) {
  std::string text = views_text(images, result);
  if (result.covariance.size() > 0) {
    text += fmt::format("{}, {} × {} pixels\n", model_name(result.camera), result.camera.width,
                        result.camera.height) +
            numbers_text(result);
    text += fmt::format(
        "corners are off by {:.2f} px; between views by {:.1f} times what independent corners "
        "give; board bent by {:.1f} mm\n",
        result.rms, std::sqrt(result.view_ratio), 1e3 * result.bow);
    text += fmt::format("corners in {:.0f} % of the image; boards up to {:.0f}° from parallel\n",
                        100 * result.coverage.share, result.tilt_spread / kDegree);
    if (const std::string missing = describe_coverage(result); !missing.empty())
      text += missing + "\n";
  }
  if (!result.usable()) return text + "not usable: " + result.reason + "\n";
  const IntrinsicsSigma sigma = stated_sigma(result);
  return text + fmt::format(
                    "usable, from {} views; for infuse calibrate: --intrinsics-sigma "
                    "{:.2g},{:.2g},{:.2g}\n",
                    result.used, 100 * sigma.focal_length, sigma.principal_point, sigma.radial);
}

}  // namespace infuse::daemon
