#include "daemon/commands/calibration_report.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "daemon/commands/calibration_pictures.hpp"
#include "drivers/recording/text_file.hpp"
#include "fusion/calibration/landscape.hpp"

namespace infuse::daemon {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kReachRotation = 1.5 / kDegrees;
constexpr double kReachTranslation = 0.3;
constexpr size_t kFewPoints = 20'000;
constexpr std::array<const char*, 6> kAxes{"about x", "about y", "about z",
                                           "along x", "along y", "along z"};

const char* kHead = R"(<!doctype html><html lang="en"><meta charset="utf-8">
<title>infuse calibrate</title><style>
body{font:15px/1.45 system-ui,sans-serif;max-width:1280px;margin:2em auto;padding:0 1em;color:#222}
h2{margin-top:2em;border-bottom:1px solid #ccc}pre{background:#f4f4f2;padding:1em;overflow:auto}
figure{margin:1em 0}figure img{width:100%}figcaption,.note{color:#666;font-size:13px}
.row{display:flex;flex-wrap:wrap;gap:14px}.map img{width:180px;height:180px;image-rendering:pixelated;
border:1px solid #999}.map{width:182px;font-size:12px;text-align:center}
table{border-collapse:collapse}td,th{padding:2px 10px;text-align:right;font-variant-numeric:tabular-nums}
td:first-child{text-align:left}.bar{background:#4a7;height:10px;display:inline-block}
.yes{color:#175}.no{color:#b22}svg{background:#fafaf8;border:1px solid #ccc}</style>
)";

/// What a person's text may hold, as HTML.
std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<') {
      out += "&lt;";
    } else if (c == '&') {
      out += "&amp;";
    } else {
      out += c;
    }
  }
  return out;
}

std::string answer(const ScenePairs& pairs, const std::vector<CalibrationRun>& runs) {
  const calibration::CalibrationResult& result = runs.front().result;
  std::string html =
      fmt::format("<h1>{} against {}</h1>", escaped(camera_names(pairs)), escaped(pairs.lidar));
  html += result.usable() ? "<p class=yes><b>Usable.</b></p>"
                          : "<p class=no><b>Not usable:</b> " + escaped(result.reason) + "</p>";
  for (const CalibrationRun& run : runs) {
    html += "<pre>" + escaped(to_text(run, pairs)) + "</pre>";
  }
  return html;
}

std::string overlays(const ScenePairs& pairs, const CalibrationRun& run) {
  std::string html =
      "<h2>Lidar over picture</h2><p class=note>Returns by distance, red near, blue far. Edges of "
      "colour should lie on edges of the picture.</p>";
  const size_t count = std::min<size_t>(3, pairs.pairs.size());
  for (size_t k = 0; k < count; ++k) {
    const ScenePair& pair = pairs.pairs[(2 * k + 1) * pairs.pairs.size() / (2 * count)];
    for (const auto& [T, when] :
         {std::pair(run.start, "before"), std::pair(run.result.T_head_lidar, "after")}) {
      html += fmt::format("<figure><img src=\"{}\"><figcaption>{}, {}</figcaption></figure>",
                          data_url(draw_overlay(pair, pairs.cameras[pair.camera].intrinsics,
                                                T_camera_head(pairs, pair.camera) * T)),
                          escaped(pair.name), when);
    }
  }
  return html;
}

/// A curve over −reach … reach in a frame of its own.
std::string curve(const std::array<double, calibration::Landscape::kAlong>& values,
                  const std::string& title, double reach, const char* unit) {
  constexpr double kWidth = 380;
  constexpr double kHeight = 150;
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  const double span = std::max(*greatest - *least, 1e-300);
  std::string points;
  for (size_t k = 0; k < values.size(); ++k) {
    points += fmt::format("{:.1f},{:.1f} ",
                          kWidth * static_cast<double>(k) / static_cast<double>(values.size() - 1),
                          kHeight - 12 - (kHeight - 24) * (values[k] - *least) / span);
  }
  return fmt::format(
      "<figure><svg width={0} height={1} viewBox=\"0 0 {0} {1}\"><line x1={2} y1=0 x2={2} y2={1} "
      "stroke=#bbb stroke-dasharray=4 /><polyline points=\"{3}\" fill=none stroke=#2563a8 "
      "stroke-width=2 /></svg><figcaption>{4}, &minus;{5:.1f} &hellip; {5:.1f} {6}; measure "
      "{7:.5f} "
      "&hellip; {8:.5f}</figcaption></figure>",
      kWidth, kHeight, kWidth / 2, points, title, reach, unit, *least, *greatest);
}

std::string landscape(const CalibrationRun& run, calibration::CoarseToFine& search) {
  const Eigen::Isometry3d& T = run.result.T_head_lidar;
  const calibration::VisiblePoints all = search.visible(T, 3 * kFewPoints);
  const calibration::VisiblePoints few = search.visible(T, kFewPoints);
  calibration::Objective fine = search.objective(all, run.options.fine.back().sigma);
  calibration::Objective coarse = search.objective(few, run.options.support_sigma);
  const auto around = calibration::look_around(fine, coarse, T, kReachRotation, kReachTranslation);
  std::string html =
      "<h2>The measure around the result</h2><p class=note>Camera axes: x right, y down, z ahead. "
      "The result is in the middle; a peak there, and nowhere as high, is what one wants to see.";
  if (!run.options.leading.empty()) html += " Drawn for the measure that led there.";
  html += "</p><div class=row>";
  for (size_t axis = 0; axis < 6; ++axis) {
    html += axis < 3 ? curve(around.along[axis], kAxes[axis], kReachRotation * kDegrees, "deg")
                     : curve(around.along[axis], kAxes[axis], 100 * kReachTranslation, "cm");
  }
  html += "</div><div class=row>";
  for (const auto& map : around.maps) {
    html +=
        fmt::format("<div class=map><img src=\"{}\"><br>&rarr; {}<br>&uarr; {}</div>",
                    data_url(draw_map(map.values, calibration::Landscape::kAcross)),
                    kAxes[static_cast<size_t>(map.first)], kAxes[static_cast<size_t>(map.second)]);
  }
  return html + "</div>";
}

/// Counts of lidar value against image value, by their roots, so that what is rare is seen.
std::string histogram(const calibration::Objective::Samples& samples, const std::string& caption) {
  constexpr int kBins = 32;
  std::vector<double> counts(size_t{kBins} * kBins, 0.0);
  const float most = *std::max_element(samples.lidar.begin(), samples.lidar.end());
  for (size_t i = 0; i < samples.lidar.size(); ++i) {
    if (!std::isfinite(samples.image[i])) continue;
    const auto bin = [](float part) {
      return std::clamp(static_cast<int>(part * kBins), 0, kBins - 1);
    };
    counts[static_cast<size_t>(bin(samples.image[i]) * kBins +
                               bin(samples.lidar[i] / std::max(most, 1e-6F)))] += 1;
  }
  for (double& count : counts) count = std::sqrt(count);
  return fmt::format("<div class=map><img src=\"{}\"><br>{}</div>",
                     data_url(draw_map(counts, kBins)), caption);
}

/// The terms that pictures show: of measures that take long those that lead there.
const std::vector<calibration::TermOptions>& drawn(const CalibrationRun& run) {
  return run.options.leading.empty() ? run.options.terms : run.options.leading;
}

std::string histograms(const CalibrationRun& run, calibration::CoarseToFine& search) {
  std::string html =
      "<h2>Joint histograms</h2><p class=note>Lidar feature to the right, picture feature up. "
      "Dependence is structure beyond rows and columns.</p><div class=row>";
  for (const auto& [T, when] :
       {std::pair(run.start, "before"), std::pair(run.result.T_head_lidar, "after")}) {
    const calibration::VisiblePoints points = search.visible(T, 0);
    if (points.size() == 0) continue;
    calibration::Objective measure = search.objective(points, run.options.fine.back().sigma);
    for (size_t term = 0; term < drawn(run).size(); ++term) {
      html += histogram(measure.samples(T, term), fmt::format("term {}, {}", term + 1, when));
    }
  }
  return html + "</div>";
}

std::string scenes(const ScenePairs& pairs, const CalibrationRun& run) {
  std::string html =
      "<h2>Scenes</h2><p class=note>Support: share of 12 wrong rotations (&plusmn;1&deg;, "
      "&plusmn;2&deg;) at which the scene by itself fits worse; about one half where picture and "
      "scan do not belong together. Pull: by how many standard deviations the scene alone would "
      "move the result.</p><table><tr><th>scene<th>points<th>measure<th>support<th><th>pull"
      "<th>gap, ms<th>motion";
  for (size_t s = 0; s < pairs.pairs.size(); ++s) {
    const calibration::SceneSupport& scene = run.result.scenes[s];
    const auto& pull = run.result.uncertainty.pull;
    html += fmt::format(
        "<tr><td>{}<td>{}<td>{:.4f}<td>{:.2f}<td style=\"text-align:left;width:130px\"><span "
        "class=bar style=\"width:{:.0f}px\"></span><td>{:.1f}<td>{:.1f}<td>{}",
        escaped(pairs.pairs[s].name), scene.points, scene.value, scene.support, 120 * scene.support,
        s < pull.size() ? pull[s] : 0.0, 1e3 * to_seconds(pairs.pairs[s].gap),
        pairs.pairs[s].uncompensated.empty() ? "corrected" : escaped(pairs.pairs[s].uncompensated));
  }
  return html + "</table>";
}

}  // namespace

Result<void> write_report(const std::filesystem::path& folder, const ScenePairs& pairs,
                          const std::vector<CalibrationRun>& runs) {
  const CalibrationRun& run = runs.front();
  const std::array<double, 2> sigmas{run.options.fine.back().sigma, run.options.support_sigma};
  calibration::ImagePyramid images(run.scenes, drawn(run), sigmas);
  calibration::CoarseToFine search(
      run.scenes, run.cameras, drawn(run), images, run.options.visibility, run.options.maximize,
      run.start.inverse().translation(), run.options.start_translation);
  const std::string page = kHead + answer(pairs, runs) + overlays(pairs, run) +
                           landscape(run, search) + histograms(run, search) + scenes(pairs, run);
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  return recording::write_text(folder / "index.html", page + "</html>\n");
}

}  // namespace infuse::daemon
