#include "daemon/tools/calibrate/calibration_comparison.hpp"

#include <spdlog/fmt/fmt.h>

#include "daemon/drawing/calibration_images.hpp"
#include "daemon/protocol/number_json.hpp"
#include "daemon/tools/calibrate/calibration_run.hpp"
#include "drivers/camera/png_encoder.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/text/text_file.hpp"
#include "fusion/calibration/distributions.hpp"
#include "fusion/geometry/extrinsic_error.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kDrawnPairs = 3;

Json fit_json(const calibration::SceneFit& fit) {
  return {{"edge_gradient", rounded(fit.edge_gradient)}, {"dependence", rounded(fit.dependence)}};
}

/// The difference axis by axis, and whether the new one's covariance explains it.
std::string difference_text(const ComparedExtrinsics& compared) {
  const auto squared = compared.mahalanobis_squared();
  if (!squared) return {};
  constexpr const char* kAxisNames[] = {"rx", "ry", "rz", "tx", "ty", "tz"};
  std::string text = "  new against old:";
  for (Eigen::Index k = 0; k < 6; ++k) {
    const double unit = k < 3 ? 1 / kDegree : 100;
    text +=
        fmt::format("{}{} {:+.2f} ± {:.2f}{}", k % 3 == 0 ? " " : ", ", kAxisNames[k],
                    unit * compared.difference()(k), unit * std::sqrt((*compared.covariance)(k, k)),
                    k % 3 != 2 ? ""
                    : k < 3    ? " deg;"
                               : " cm");
  }
  const double chance = calibration::chi_squared_exceeded(*squared, 6);
  return text + fmt::format(
                    "\n  a difference as large comes by the new one's own error in {} (M² = "
                    "{:.1f})\n",
                    chance < 1e-4 ? "less than 1 of 10 000"
                                  : fmt::format("{:.2g} % of drives", 100 * chance),
                    *squared);
}

}  // namespace

const char* ComparedExtrinsics::better() const {
  if (!comparison.usable() || comparison.p_value >= calibration::CompareOptions{}.max_p_value) {
    return "neither";
  }
  return comparison.better > 0 ? "new" : "old";
}

std::optional<double> ComparedExtrinsics::mahalanobis_squared() const {
  if (!covariance) return std::nullopt;
  return difference().dot(covariance->ldlt().solve(difference()));
}

ScenePairs hold_out(ScenePairs& pairs) {
  ScenePairs held_out = pairs;
  held_out.pairs.clear();
  std::vector<ScenePair> kept;
  std::vector<size_t> seen(pairs.cameras.size(), 0);
  for (ScenePair& pair : pairs.pairs) {
    const bool out = is_held_out(seen[pair.camera]++);
    (out ? held_out.pairs : kept).push_back(std::move(pair));
  }
  pairs.pairs = std::move(kept);
  return held_out;
}

ComparedExtrinsics compare_on(const ScenePairs& held_out,
                              std::span<const calibration::Scene> scenes,
                              const Eigen::Isometry3d& T_old, const Eigen::Isometry3d& T_new,
                              const std::optional<geometry::Matrix6>& covariance) {
  return {.T_old = T_old,
          .T_new = T_new,
          .comparison =
              calibration::compare_extrinsics(scenes, rig_cameras(held_out), T_old, T_new, {}),
          .covariance = covariance};
}

Json to_json(const ComparedExtrinsics& compared) {
  const calibration::ExtrinsicComparison& comparison = compared.comparison;
  Json json{{"better", compared.better()},
            {"reason", comparison.reason},
            {"p_value", comparison.p_value},
            {"bias_share", rounded(comparison.bias_share)},
            {"scenes", comparison.scenes.size()},
            {"independent_scenes", comparison.independent},
            {"old", fit_json(comparison.mean_a)},
            {"new", fit_json(comparison.mean_b)},
            {"difference", by_row(compared.difference())}};
  if (const auto squared = compared.mahalanobis_squared()) {
    json["mahalanobis_squared"] = rounded(*squared);
    json["chance"] = calibration::chi_squared_exceeded(*squared, 6);
  }
  return json;
}

std::string to_text(const ComparedExtrinsics& compared) {
  const calibration::ExtrinsicComparison& comparison = compared.comparison;
  const calibration::SceneFit &a = comparison.mean_a, &b = comparison.mean_b;
  const Eigen::Isometry3d apart = compared.T_new * compared.T_old.inverse();
  std::string text = fmt::format(
      "compared on {} scenes held out, of {} places; {:.3f} deg, {:.1f} cm apart\n"
      "  image gradient at depth edges (rank): old {:.4f}, new {:.4f}\n"
      "  dependence: old {:.5f}, new {:.5f}\n",
      comparison.scenes.size(), comparison.independent,
      Eigen::AngleAxisd(apart.linear()).angle() / kDegree,
      100 *
          (compared.T_new.inverse().translation() - compared.T_old.inverse().translation()).norm(),
      a.edge_gradient, b.edge_gradient, a.dependence, b.dependence);
  text += difference_text(compared);
  if (!comparison.usable()) return text + "  no verdict: " + comparison.reason + "\n";
  if (comparison.bias_share == 1) {
    return text + "  neither is better: half a pixel of bias could make up the difference\n";
  }
  const std::string better = compared.better();
  text += better == "neither" ? "  neither is better" : "  the " + better + " one is better";
  return text + fmt::format(" (p = {:.2g})\n", comparison.p_value);
}

Result<void> write_overlays(const std::filesystem::path& file, const ScenePairs& held_out,
                            const ComparedExtrinsics& compared) {
  std::vector<CameraFrame> images;
  for (const size_t k : choose_drawn(held_out, kDrawnPairs)) {
    const ScenePair& pair = held_out.pairs[k];
    const Eigen::Isometry3d T_camera_refcam =
        infuse::daemon::T_camera_refcam(held_out, pair.camera);
    const CameraIntrinsics& intrinsics = held_out.cameras[pair.camera].intrinsics;
    for (const auto& T : {compared.T_old, compared.T_new}) {
      images.push_back(draw_overlay(pair, intrinsics, T_camera_refcam * T));
    }
  }
  if (images.empty()) return fail("no image was held out", file.string());
  return camera::encode_png(join_images(images, 2)).and_then([&](const auto& png) {
    return text::write_text(file, {reinterpret_cast<const char*>(png.data()), png.size()});
  });
}

}  // namespace infuse::daemon
