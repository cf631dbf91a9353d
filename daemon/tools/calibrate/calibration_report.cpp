#include "daemon/tools/calibrate/calibration_report.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "daemon/drawing/calibration_images.hpp"
#include "daemon/tools/calibrate/calibration_format.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/text/text_file.hpp"
#include "fusion/calibration/landscape.hpp"
#include "fusion/geometry/extrinsic_error.hpp"

namespace infuse::daemon {
namespace {

constexpr double kMaxPlotRotation = 1.5 * kDegree;
constexpr double kMaxPlotTranslation = 0.3;
constexpr size_t kMaxCoarsePoints = 20'000;
constexpr size_t kMaxOverlays = 3;
constexpr std::array<const char*, 6> kAxes{"about x", "about y", "about z",
                                           "along x", "along y", "along z"};

const char* kHtmlHeader = R"(<!doctype html><html lang="en"><meta charset="utf-8">
<title>infuse calibrate</title><style>
body{font:15px/1.45 system-ui,sans-serif;max-width:1280px;margin:2em auto;padding:0 1em;color:#222}
h2{margin-top:2em;border-bottom:1px solid #ccc}pre{background:#f4f4f2;padding:1em;overflow:auto}
figure{margin:1em 0}figure img{width:100%}figcaption,.note{color:#666;font-size:13px}
.row{display:flex;flex-wrap:wrap;gap:14px}.map img{width:180px;height:180px;image-rendering:pixelated;
border:1px solid #999}.map{width:182px;font-size:12px;text-align:center}
table{border-collapse:collapse}td,th{padding:2px 10px;text-align:right;font-variant-numeric:tabular-nums}
.verdict{font-size:19px;font-weight:600}.tools input[type=range]{width:min(340px,60%);vertical-align:middle}
.compare{position:relative}.compare img{width:100%;display:block}.compare .after{position:absolute;inset:0}[hidden]{display:none}
#compared{overflow:auto}#compared.large .compare{width:200%}[aria-pressed=true]{font-weight:700}
td:first-child{text-align:left}.bar{background:#4a7;height:10px;display:inline-block}
.yes{color:#175}.no{color:#b22}svg{background:#fafaf8;border:1px solid #ccc}</style>
)";

/// Shows one scene at a time, cut at the slider, which may blink.
const char* kCompareCode = R"(<script>
const all = q => [...document.querySelectorAll(q)], cut = document.getElementById('cut');
const show = k => all('.compare').forEach((e, i) => { e.hidden = i !== k; all('.scene')[i].setAttribute('aria-pressed', i === k); });
const apply = () => all('.after').forEach(e => { e.style.clipPath = `inset(0 0 0 ${cut.value}%)`; });
let turn = 0;
all('.scene').forEach((e, i) => e.addEventListener('click', () => show(i)));
cut.addEventListener('input', apply);
document.getElementById('blink').addEventListener('click', e => {
  clearInterval(turn);
  turn = turn ? 0 : setInterval(() => { cut.value = cut.value < 50 ? 100 : 0; apply(); }, 700);
  e.target.textContent = turn ? 'Stop' : 'Blink';
});
document.getElementById('zoom').addEventListener('change', e => {
  document.getElementById('compared').classList.toggle('large', e.target.checked);
});
show(0);
apply();
</script>)";

/// Escapes text for HTML.
std::string escape_html(const std::string& text) {
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

/// The result against where it started.
geometry::ExtrinsicError move_of(const CalibrationRun& run) {
  return geometry::extrinsic_error(run.result.T_refcam_lidar, run.initial_pose,
                                   run.cameras.front().model);
}

/// How far the result moved the calibration, and how sure it is, along each axis.
std::string sigma_table_html(const CalibrationRun& run) {
  const geometry::ExtrinsicError moved = move_of(run);
  const geometry::Matrix6 covariance = run.result.covariance();
  std::string html = "<table><tr><th>axis of the camera<th>moved by<th>standard deviation<th>";
  for (int axis = 0; axis < 6; ++axis) {
    const double unit = axis < 3 ? kDegree : 0.01;
    const int digits = axis < 3 ? 3 : 2;
    html += fmt::format("<tr><td>{}<td>{:+.{}f}<td>{:.{}f}<td>{}", kAxes[static_cast<size_t>(axis)],
                        moved.by_axis(axis) / unit, digits,
                        std::sqrt(std::max(0.0, covariance(axis, axis))) / unit, digits,
                        axis < 3 ? "deg" : "cm");
  }
  return html + "</table>";
}

std::string result_html(const ScenePairs& pairs, const CalibrationRun& run) {
  const geometry::ExtrinsicError moved = move_of(run);
  const std::string title = fmt::format("<h1>{} against {}</h1>", escape_html(camera_names(pairs)),
                                        escape_html(pairs.lidar));
  const std::string verdict =
      run.result.usable()
          ? fmt::format(
                "yes\">&#10003; Usable: {} scenes turn the camera by {:.2f}&deg; and move "
                "it by {:.1f} cm, {:.1f} px in the image.",
                pairs.pairs.size(), moved.rotation / kDegree, 100 * moved.translation, moved.pixels)
          : "no\">&#10005; Not usable: " + escape_html(run.result.reason);
  return title + "<p class=\"verdict " + verdict + "</p>" + sigma_table_html(run);
}

/// What the command prints, for who wants it all.
std::string printed_html(const ScenePairs& pairs, const std::vector<CalibrationRun>& runs) {
  std::string html = "<details><summary>What infuse calibrate printed</summary>";
  for (const CalibrationRun& run : runs) {
    html += "<pre>" + escape_html(to_text(run, pairs)) + "</pre>";
  }
  return html + "</details>";
}

/// Lidar over image before and after, one above the other with a slider between them; one scene is
/// shown at a time.
std::string overlays_html(const ScenePairs& pairs, const CalibrationRun& run) {
  std::string figures;
  std::string html =
      "<h2>Lidar over image, before and after</h2><p class=note>Left of the slider before, right "
      "after. Returns by distance, bright near, dark far: where the colour jumps, the image should "
      "have an edge.</p><p class=tools>";
  for (const size_t k : choose_drawn(pairs, kMaxOverlays)) {
    const ScenePair& pair = pairs.pairs[k];
    const auto image = [&](const Eigen::Isometry3d& T) {
      return data_url(draw_overlay(pair, run.cameras[pair.camera].model.intrinsics(),
                                   T_camera_refcam(pairs, pair.camera) * T));
    };
    html += fmt::format("<button class=scene>{}</button> ", escape_html(pair.name));
    figures += fmt::format(
        "<div class=compare><img src=\"{}\" alt=before><img class=after "
        "src=\"{}\" alt=after></div>",
        image(run.initial_pose), image(run.result.T_refcam_lidar));
  }
  return html +
         "<input id=cut type=range value=50 aria-label=\"before and after\"> <button id=blink>"
         "Blink</button> <label><input id=zoom type=checkbox> twice as large</label></p>"
         "<div id=compared>" +
         figures + "</div>" + kCompareCode;
}

/// Plots a curve over −max_offset … max_offset.
std::string curve_html(const std::array<double, calibration::Landscape::kSamplesPerAxis>& values,
                       const std::string& title, double max_offset, const char* unit) {
  constexpr double kWidth = 380;
  constexpr double kHeight = 150;
  const auto [min_value, max_value] = std::minmax_element(values.begin(), values.end());
  const double span = std::max(*max_value - *min_value, 1e-300);
  std::string points;
  for (size_t k = 0; k < values.size(); ++k) {
    points += fmt::format("{:.1f},{:.1f} ",
                          kWidth * static_cast<double>(k) / static_cast<double>(values.size() - 1),
                          kHeight - 12 - (kHeight - 24) * (values[k] - *min_value) / span);
  }
  return fmt::format(
      "<figure><svg width={0} height={1} viewBox=\"0 0 {0} {1}\"><line x1={2} y1=0 x2={2} y2={1} "
      "stroke=#bbb stroke-dasharray=4 /><polyline points=\"{3}\" fill=none stroke=#2563a8 "
      "stroke-width=2 /></svg><figcaption>{4}, &minus;{5:.1f} &hellip; {5:.1f} {6}; measure "
      "{7:.5f} "
      "&hellip; {8:.5f}</figcaption></figure>",
      kWidth, kHeight, kWidth / 2, points, title, max_offset, unit, *min_value, *max_value);
}

std::string objective_html(const CalibrationRun& run, calibration::CoarseToFine& search) {
  const Eigen::Isometry3d& T = run.result.T_refcam_lidar;
  const calibration::VisiblePoints fine_points = search.visible_points(T, 3 * kMaxCoarsePoints);
  const calibration::VisiblePoints coarse_points = search.visible_points(T, kMaxCoarsePoints);
  calibration::Objective fine = search.make_objective(fine_points, run.options.fine.back().sigma);
  calibration::Objective coarse = search.make_objective(coarse_points, run.options.support_sigma);
  const auto around =
      calibration::sample_landscape(fine, coarse, T, kMaxPlotRotation, kMaxPlotTranslation);
  std::string html =
      "<h2>The measure around the result</h2><p class=note>Camera axes: x right, y down, z ahead. "
      "The result is in the middle. A good result is a single, highest peak there.";
  if (!run.options.search_terms.empty()) html += " Drawn for the search measure.";
  html += "</p><div class=row>";
  for (size_t axis = 0; axis < 6; ++axis) {
    html +=
        axis < 3
            ? curve_html(around.axis_profiles[axis], kAxes[axis], kMaxPlotRotation / kDegree, "deg")
            : curve_html(around.axis_profiles[axis], kAxes[axis], 100 * kMaxPlotTranslation, "cm");
  }
  html += "</div><div class=row>";
  for (const auto& map : around.maps) {
    html +=
        fmt::format("<div class=map><img src=\"{}\"><br>&rarr; {}<br>&uarr; {}</div>",
                    data_url(draw_map(map.values, calibration::Landscape::kMapSize)),
                    kAxes[static_cast<size_t>(map.first)], kAxes[static_cast<size_t>(map.second)]);
  }
  return html + "</div>";
}

/// Joint histogram of lidar and image values; square roots of the counts, so that rare pairs are
/// visible.
std::string histogram_html(const calibration::Objective::Samples& samples,
                           const std::string& caption) {
  constexpr int kBins = 32;
  std::vector<double> counts(size_t{kBins} * kBins, 0.0);
  const float max_value = *std::max_element(samples.lidar.begin(), samples.lidar.end());
  for (size_t i = 0; i < samples.lidar.size(); ++i) {
    if (!std::isfinite(samples.image[i])) continue;
    const auto bin = [](float part) {
      return std::clamp(static_cast<int>(part * kBins), 0, kBins - 1);
    };
    counts[static_cast<size_t>(bin(samples.image[i]) * kBins +
                               bin(samples.lidar[i] / std::max(max_value, 1e-6F)))] += 1;
  }
  for (double& count : counts) count = std::sqrt(count);
  return fmt::format("<div class=map><img src=\"{}\"><br>{}</div>",
                     data_url(draw_map(counts, kBins)), caption);
}

/// The terms that are drawn: of slow measures, those of the search.
const std::vector<calibration::TermOptions>& drawn_terms(const CalibrationRun& run) {
  return run.options.search_terms.empty() ? run.options.terms : run.options.search_terms;
}

std::string histograms_html(const CalibrationRun& run, calibration::CoarseToFine& search) {
  std::string html =
      "<h2>Joint histograms</h2><p class=note>Lidar feature to the right, image feature up. "
      "Dependence is structure beyond rows and columns.</p><div class=row>";
  for (const auto& [T, when] :
       {std::pair(run.initial_pose, "before"), std::pair(run.result.T_refcam_lidar, "after")}) {
    const calibration::VisiblePoints points = search.visible_points(T, 0);
    if (points.size() == 0) continue;
    calibration::Objective measure = search.make_objective(points, run.options.fine.back().sigma);
    for (size_t term = 0; term < drawn_terms(run).size(); ++term) {
      html += histogram_html(measure.samples(T, term), fmt::format("term {}, {}", term + 1, when));
    }
  }
  return html + "</div>";
}

std::string scenes_html(const ScenePairs& pairs, const CalibrationRun& run) {
  std::string html =
      "<h2>Scenes</h2><p class=note>Support: share of 12 wrong rotations (&plusmn;1&deg;, "
      "&plusmn;2&deg;) at which the scene alone fits worse; about one half if image and "
      "sweep do not belong together. Pull: by how many standard deviations the scene alone would "
      "move the result.</p><table><tr><th>scene<th>points<th>measure<th>support<th><th>pull"
      "<th>gap, ms<th>motion";
  for (size_t s = 0; s < pairs.pairs.size(); ++s) {
    const calibration::SceneSupport& scene = run.result.scenes[s];
    const auto& pull = run.result.uncertainty.scene_influence;
    html += fmt::format(
        "<tr><td>{}<td>{}<td>{:.4f}<td>{:.2f}<td style=\"text-align:left;width:130px\"><span "
        "class=bar style=\"width:{:.0f}px\"></span><td>{:.1f}<td>{:.1f}<td>{}",
        escape_html(pairs.pairs[s].name), scene.points, scene.value, scene.support,
        120 * scene.support, s < pull.size() ? pull[s] : 0.0, 1e3 * to_seconds(pairs.pairs[s].gap),
        pairs.pairs[s].deskew_reason.empty() ? "corrected"
                                             : escape_html(pairs.pairs[s].deskew_reason));
  }
  return html + "</table>";
}

}  // namespace

Result<void> write_report(const std::filesystem::path& folder, const ScenePairs& pairs,
                          const std::vector<CalibrationRun>& runs) {
  const CalibrationRun& run = runs.front();
  const std::array<calibration::ImageBlur, 2> blurs{
      calibration::ImageBlur::in_angle(run.options.fine.back().sigma),
      calibration::ImageBlur::in_angle(run.options.support_sigma)};
  calibration::ImagePyramid images(run.scenes, run.cameras, drawn_terms(run), blurs);
  calibration::CoarseToFine search(run.scenes, run.cameras, drawn_terms(run), images,
                                   run.options.visibility, run.options.maximize,
                                   run.initial_pose.inverse().translation(),
                                   run.options.initial_translation_sigma);
  const std::string page = kHtmlHeader + result_html(pairs, run) + overlays_html(pairs, run) +
                           objective_html(run, search) + histograms_html(run, search) +
                           scenes_html(pairs, run) + printed_html(pairs, runs);
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  return text::write_text(folder / "index.html", page + "</html>\n");
}

}  // namespace infuse::daemon
