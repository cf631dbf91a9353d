#include "tests/study/rigs/rig_study.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <istream>
#include <map>
#include <ostream>
#include <random>

#include "drivers/measurement/angles.hpp"
#include "fusion/calibration/compare_extrinsics.hpp"
#include "fusion/geometry/draw_uniform.hpp"

namespace infuse::study {
namespace {

using calibration::RigCamera;
using calibration::Scene;
using geometry::Vector6;

constexpr double kChiSquare95 = 12.59;  // 95 % of 6 degrees of freedom
constexpr double kChiSquare997 = 19.8;  // 99.7 %
constexpr double kLateSeconds = 0.1;
constexpr size_t kMaxSets = 4;  // of disjoint scenes, in a cell
constexpr double kStartAngle = 2 * kDegree, kStartLength = 0.08;

/// A kind of trial: which scenes, and what is done to the camera and to them.
struct Kind {
  const char* name;
  size_t scenes;
  void (*change)(CameraIntrinsics& camera, std::vector<RigScene>& scenes) = nullptr;
  bool neighbours = false;
  bool stated = true;  // to what the intrinsics are known
};

/// Draws of the standard normal distribution (Box and Muller); the standard's differ between
/// libraries.
double draw_normal(std::mt19937_64& random) {
  const double u = static_cast<double>((random() >> 11) + 1) * 0x1p-53;
  const double v = static_cast<double>(random() >> 11) * 0x1p-53;
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * M_PI * v);
}

/// The sweeps as of `seconds` before the exposure.
void shift_time(std::vector<RigScene>& scenes, double seconds) {
  for (RigScene& scene : scenes) {
    const Eigen::Isometry3d there = geometry::exp(seconds * scene.twist);
    for (size_t i = 0; i < scene.sweep.size(); ++i) {
      const Eigen::Vector3d p =
          there * Eigen::Vector3d(scene.sweep.x[i], scene.sweep.y[i], scene.sweep.z[i]);
      scene.sweep.x[i] = static_cast<float>(p.x());
      scene.sweep.y[i] = static_cast<float>(p.y());
      scene.sweep.z[i] = static_cast<float>(p.z());
    }
  }
}

void raise_centre(CameraIntrinsics& camera, std::vector<RigScene>&) {
  camera.cy += 0.024 * camera.width;
}
void raise_centre_by_pixels(CameraIntrinsics& camera, std::vector<RigScene>&) { camera.cy += 15; }
void shorten_focal(CameraIntrinsics& camera, std::vector<RigScene>&) {
  camera.fx *= 0.97;
  camera.fy *= 0.97;
}
void drop_distortion(CameraIntrinsics& camera, std::vector<RigScene>&) { camera.distortion = {}; }
void shuffle_images(CameraIntrinsics&, std::vector<RigScene>& scenes) {
  for (size_t k = 0; k + 3 < scenes.size(); ++k) std::swap(scenes[k].frame, scenes[k + 3].frame);
}
void delay_images(CameraIntrinsics&, std::vector<RigScene>& scenes) {
  shift_time(scenes, kLateSeconds);
}
/// The first place again and again, with noise of ranges and pixels.
void stand_still(CameraIntrinsics&, std::vector<RigScene>& scenes) {
  std::mt19937_64 random(1);
  const auto uniform = [&] { return geometry::draw_uniform(random); };
  for (size_t k = 1; k < scenes.size(); ++k) {
    scenes[k] = scenes[0];
    for (uint8_t& pixel : scenes[k].frame.pixels) {
      pixel = static_cast<uint8_t>(std::clamp(pixel + 5 * uniform(), 0.0, 255.0));
    }
    Sweep& sweep = scenes[k].sweep;
    for (size_t i = 0; i < sweep.size(); ++i) {
      const auto factor = static_cast<float>(1 + 0.02 * uniform() / std::max(sweep.range[i], 1.0F));
      for (auto* values : {&sweep.x, &sweep.y, &sweep.z, &sweep.range}) (*values)[i] *= factor;
    }
  }
}

constexpr Kind kRight{"right", 10};
constexpr Kind kFaults[] = {
    {"cy + 2.4 % of the width", 10, raise_centre}, {"f - 3 %", 10, shorten_focal},
    {"distortion left out", 10, drop_distortion},  {"images of other places", 10, shuffle_images},
    {"images 0.1 s late", 10, delay_images},       {"one standing place", 10, stand_still},
};
constexpr Kind kUnmeasured[] = {
    {"right", 20},
    {"cy + 15 px", 20, raise_centre_by_pixels},
    {.name = "right; intrinsics not stated", .scenes = 20, .stated = false},
    {.name = "cy + 15 px; intrinsics not stated",
     .scenes = 20,
     .change = raise_centre_by_pixels,
     .stated = false},
};
constexpr Kind kCells[] = {
    {"diverse", 3},
    {"diverse", 5},
    {"diverse", 10},
    {"diverse", 20},
    {"diverse", 40},
    {"neighbours", 3, nullptr, true},
    {"neighbours", 5, nullptr, true},
    {"neighbours", 10, nullptr, true},
    {"neighbours", 20, nullptr, true},
    {"neighbours", 40, nullptr, true},
};

/// One of several disjoint sets of the scenes: interleaved where they are diverse, else one after
/// another.
struct SceneSet {
  size_t which = 0, of = 1;
};

std::vector<RigScene> select_scenes(const RigRecording& recording, const Kind& kind, SceneSet set) {
  const std::vector<RigScene>& from = kind.neighbours ? recording.neighbours : recording.diverse;
  std::vector<RigScene> selected;
  const size_t count = std::min(kind.scenes, from.size());
  for (size_t k = 0; k < count; ++k) {
    if (set.of == 1) {
      selected.push_back(from[(2 * k + 1) * from.size() / (2 * count)]);
    } else if (kind.neighbours) {
      selected.push_back(from[set.which * count + k]);
    } else {
      selected.push_back(from[k * (from.size() / count) + set.which]);
    }
  }
  return selected;
}

/// Standard deviations of a covariance, degrees and centimetres.
Eigen::RowVectorXd shown_sigmas(const geometry::Matrix6& covariance) {
  Vector6 sigma = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  sigma.head<3>() /= kDegree;
  sigma.tail<3>() *= 100;
  return sigma.transpose();
}

/// Writes how the fit of the result compares with that of the truth, and with that of the maximum
/// nearest to the truth.
void write_from_truth(std::ostream& out, const RigRecording& recording,
                      const std::vector<Scene>& scenes, const std::vector<RigCamera>& cameras,
                      const Eigen::Isometry3d& found) {
  calibration::CalibrateOptions options{.restarts = 0, .check_intrinsics = false};
  options.screen = {.half_width = 0, .survivors = 0};
  options.coarse = {{.sigma = 2, .tolerance = 1e-2}};
  options.fine = {{.sigma = 1}};
  const Eigen::Isometry3d near =
      calibration::calibrate(scenes, cameras, recording.T_camera_lidar, options).T_refcam_lidar;
  const auto write = [&](const char* name, const Eigen::Isometry3d& pose) {
    const Vector6 error = geometry::log(recording.T_camera_lidar * pose.inverse());
    const auto fit = calibration::compare_extrinsics(scenes, cameras, pose, found, {.bias = 0});
    out << "  " << name << ": " << error.head<3>().norm() / kDegree << " degrees, "
        << 100 * error.tail<3>().norm() << " cm; edges " << fit.mean_a.edge_gradient << " (result "
        << fit.mean_b.edge_gradient << "), dependence " << fit.mean_a.dependence << " ("
        << fit.mean_b.dependence << "), result better by " << fit.better << ", p " << fit.p_value
        << '\n';
  };
  write("truth", recording.T_camera_lidar);
  write("maximum nearest to it", near);
}

/// Writes what the stated covariance of a trial is made of, beside its error axis by axis.
void write_details(std::ostream& out, const RigTrial& trial, const RigRecording& recording,
                   const CameraIntrinsics& stated, const calibration::CalibrationResult& result) {
  const Eigen::IOFormat short_row(3, 0, " ", "", "", "", "", "");
  Vector6 error = geometry::log(recording.T_camera_lidar * result.T_refcam_lidar.inverse());
  error.head<3>() /= kDegree;
  error.tail<3>() *= 100;
  out << trial.seed << ' ' << trial.kind << ' ' << trial.lidar << ' ' << trial.width
      << ", f = " << stated.fx << " px: " << (trial.usable ? "usable" : trial.reason)
      << "\n  restarts " << result.converged_restarts << " of " << result.restarts << ", support "
      << result.support << "\n  error (degrees, cm)     " << error.transpose().format(short_row)
      << "\n  sigma                   " << shown_sigmas(result.covariance()).format(short_row)
      << "\n  of the scenes           "
      << shown_sigmas(result.uncertainty.covariance).format(short_row) << '\n';
  for (const calibration::ParameterCheck& one : result.parameter_checks) {
    Vector6 moved = one.pose_sensitivity;
    moved.head<3>() /= kDegree;
    moved.tail<3>() *= 100;
    out << "  " << one.parameter << ": " << one.value << " +- " << one.sigma << ' ' << one.unit
        << ", known to " << one.known_sigma << ", unseen " << one.unseen_sigma << ", pose per unit "
        << moved.transpose().format(short_row) << '\n';
  }
  if (result.intrinsics.empty() || !result.intrinsics.front()) return;
  const calibration::IntrinsicsEstimate& estimate = *result.intrinsics.front();
  const CameraIntrinsics& truth = recording.camera;
  const Eigen::Vector4d right(std::log(truth.fx / stated.fx), truth.cx - stated.cx,
                              truth.cy - stated.cy, truth.distortion[0] - stated.distortion[0]);
  out << "  intrinsics, true        " << right.transpose().format(short_row)
      << "\n  estimated               " << estimate.correction.transpose().format(short_row)
      << "\n  sigma                   "
      << estimate.covariance.diagonal().cwiseSqrt().transpose().format(short_row) << "\n  scenes "
      << estimate.improved_scenes << " of " << estimate.scenes << ", t " << estimate.significance
      << (estimate.converged ? "" : ", not converged") << '\n';
}

RigTrial try_kind(const RigRecording& recording, const Kind& kind, uint64_t seed,
                  std::ostream* details, SceneSet set = {}) {
  std::vector<RigScene> recorded = select_scenes(recording, kind, set);
  CameraIntrinsics stated = recording.camera;
  std::mt19937_64 random(seed + 1'000'000 * set.which);
  draw_known_errors(stated, random);
  draw_known_errors(recorded, random);
  if (kind.change != nullptr) kind.change(stated, recorded);
  Vector6 off;
  for (int k = 0; k < 6; ++k) {
    off(k) = geometry::draw_uniform(random) * (k < 3 ? kStartAngle : kStartLength);
  }
  const Eigen::Isometry3d initial = geometry::exp(off) * recording.T_camera_lidar;
  const std::vector<RigCamera> cameras{{geometry::CameraModel(stated)}};
  const std::vector<Scene> scenes = make_scenes(recorded, cameras[0], initial);
  calibration::CalibrateOptions options{.seed = seed};
  options.known.intrinsics_stated = kind.stated;
  const std::clock_t began = std::clock();
  const calibration::CalibrationResult result =
      calibration::calibrate(scenes, cameras, initial, options);
  const double cpu_s = static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
  RigTrial trial = judge(result, recording.T_camera_lidar);
  trial.seed = seed;
  trial.kind = kind.name;
  trial.lidar = recording.lidar;
  trial.width = stated.width;
  trial.height = stated.height;
  trial.fisheye = stated.model == CameraIntrinsics::Model::kFisheye;
  trial.scenes = scenes.size();
  trial.cpu_s = cpu_s;
  if (details != nullptr) {
    write_details(*details, trial, recording, stated, result);
    write_from_truth(*details, recording, scenes, cameras, result.T_refcam_lidar);
  }
  return trial;
}

}  // namespace

void draw_known_errors(CameraIntrinsics& camera, std::mt19937_64& random) {
  const calibration::KnownParameters known;
  const double focal = std::exp(known.focal_sigma * draw_normal(random));
  camera.fx *= focal;
  camera.fy *= focal;
  camera.cx += known.principal_point_sigma * draw_normal(random);
  camera.cy += known.principal_point_sigma * draw_normal(random);
  camera.distortion[0] += known.radial_sigma * draw_normal(random);
}

void draw_known_errors(std::vector<RigScene>& scenes, std::mt19937_64& random) {
  const calibration::KnownParameters known;
  shift_time(scenes, to_seconds(known.time_sigma) * draw_normal(random));
}

std::vector<Scene> make_scenes(const std::vector<RigScene>& recorded, const RigCamera& camera,
                               const Eigen::Isometry3d& initial) {
  const calibration::SceneOptions options{.rings =
                                              features::ring_directions(camera.model, initial)};
  std::vector<Scene> scenes;
  for (const RigScene& one : recorded) {
    auto scene = calibration::make_scene(one.sweep, one.frame, options);
    if (!scene) continue;
    scene->twist = one.twist;
    scenes.push_back(std::move(*scene));
  }
  return scenes;
}

RigTrial judge(const calibration::CalibrationResult& result,
               const Eigen::Isometry3d& T_camera_lidar) {
  RigTrial trial{.effective_scenes = result.uncertainty.effective_scenes,
                 .usable = result.usable(),
                 .reason = result.reason};
  const Vector6 error = geometry::log(T_camera_lidar * result.T_refcam_lidar.inverse());
  trial.rotation_error = error.head<3>().norm();
  trial.translation_error =
      (T_camera_lidar.translation() - result.T_refcam_lidar.translation()).norm();
  const geometry::Matrix6 covariance = result.covariance();
  trial.rotation_sigma = std::sqrt(covariance.diagonal().head<3>().maxCoeff());
  trial.translation_sigma = std::sqrt(covariance.diagonal().tail<3>().maxCoeff());
  trial.mahalanobis_squared = error.dot(covariance.inverse() * error);
  trial.scenes_mahalanobis_squared = error.dot(result.uncertainty.covariance.inverse() * error);
  return trial;
}

bool RigTrial::right() const {
  return rotation_error <= 0.2 * kDegree && translation_error <= 0.05;
}

bool RigTrial::surely_wrong() const {
  return usable && !right() && mahalanobis_squared > kChiSquare997;
}

std::vector<RigTrial> try_rig(const RigRecording& recording, uint64_t seed, TrialSet set,
                              std::ostream* details) {
  std::vector<RigTrial> trials;
  if (set == TrialSet::kCells) {
    for (const Kind& kind : kCells) {
      const size_t all = (kind.neighbours ? recording.neighbours : recording.diverse).size();
      const size_t sets = std::clamp<size_t>(all / kind.scenes, 1, kMaxSets);
      for (size_t k = 0; k < sets; ++k)
        trials.push_back(try_kind(recording, kind, seed, details, {k, sets}));
    }
  } else if (set == TrialSet::kUnmeasured) {
    for (const Kind& kind : kUnmeasured) {
      trials.push_back(try_kind(recording, kind, seed, details));
    }
  } else {
    trials.push_back(try_kind(recording, kRight, seed, details));
    trials.push_back(try_kind(recording, kFaults[seed % std::size(kFaults)], seed, details));
  }
  return trials;
}

void write_header(std::ostream& out) {
  out << "seed,kind,lidar,width,height,fisheye,scenes,effective,usable,rotation_deg,translation_cm,"
         "sigma_deg,sigma_cm,mahalanobis2,scenes_mahalanobis2,cpu_s,reason\n";
}

void write_row(std::ostream& out, const RigTrial& t) {
  out << t.seed << ',' << t.kind << ',' << t.lidar << ',' << t.width << ',' << t.height << ','
      << t.fisheye << ',' << t.scenes << ',' << t.effective_scenes << ',' << t.usable << ','
      << t.rotation_error / kDegree << ',' << 100 * t.translation_error << ','
      << t.rotation_sigma / kDegree << ',' << 100 * t.translation_sigma << ','
      << t.mahalanobis_squared << ',' << t.scenes_mahalanobis_squared << ',' << t.cpu_s << ",\""
      << t.reason << "\"\n";
}

std::vector<RigTrial> read_rows(std::istream& in) {
  constexpr size_t kColumns = 17;
  std::vector<RigTrial> trials;
  for (std::string line; std::getline(in, line);) {
    std::vector<std::string> cells;
    for (size_t begin = 0; cells.size() < kColumns && begin <= line.size();) {
      const size_t comma = cells.size() + 1 < kColumns ? line.find(',', begin) : std::string::npos;
      const size_t end = std::min(comma, line.size());
      cells.push_back(line.substr(begin, end - begin));
      begin = end + 1;
    }
    // The header, and a row whose writing was interrupted.
    if (cells.size() < kColumns || cells[16].size() < 2 || cells[16].back() != '"') continue;
    std::vector<double> numbers;
    for (const std::string& cell : cells) numbers.push_back(std::strtod(cell.c_str(), nullptr));
    trials.push_back({.seed = static_cast<uint64_t>(numbers[0]),
                      .kind = cells[1],
                      .lidar = cells[2],
                      .width = static_cast<int>(numbers[3]),
                      .height = static_cast<int>(numbers[4]),
                      .fisheye = numbers[5] != 0,
                      .scenes = static_cast<size_t>(numbers[6]),
                      .effective_scenes = numbers[7],
                      .usable = numbers[8] != 0,
                      .reason = cells[16].substr(1, cells[16].size() - 2),
                      .rotation_error = numbers[9] * kDegree,
                      .translation_error = numbers[10] / 100,
                      .rotation_sigma = numbers[11] * kDegree,
                      .translation_sigma = numbers[12] / 100,
                      .mahalanobis_squared = numbers[13],
                      .scenes_mahalanobis_squared = numbers[14],
                      .cpu_s = numbers[15]});
  }
  return trials;
}

namespace {

/// Word for what a reason names.
std::string reason_word(const std::string& reason) {
  constexpr std::pair<const char*, const char*> kWords[] = {
      {"do not support", "support"},      {"another image time", "time"},
      {"another", "intrinsics"},          {"count as", "too few places"},
      {"at least 3", "too few scenes"},   {"restarts", "restarts"},
      {"standard deviation of", "sigma"}, {"not observable", "observability"},
      {"from the initial", "far"}};
  for (const auto& [text, word] : kWords) {
    if (reason.find(text) != std::string::npos) return word;
  }
  return reason.empty() ? "usable" : "other";
}

struct Row {
  int trials = 0, usable = 0, wrong = 0, inside = 0;
  double squares = 0;
  std::map<std::string, int> reasons;
};

/// Which trials' errors are compared with the stated covariance.
enum class Compared {
  kUsable,
  kUsableOrImprecise,  ///< also those that are refused for the standard deviation alone
};

void write_table(std::ostream& out, const std::string& heading, const std::vector<RigTrial>& trials,
                 const std::function<std::string(const RigTrial&)>& key,
                 Compared compared = Compared::kUsable) {
  std::map<std::string, Row> rows;
  for (const RigTrial& trial : trials) {
    const std::string name = key(trial);
    if (name.empty()) continue;
    Row& row = rows[name];
    ++row.trials;
    row.wrong += trial.surely_wrong() ? 1 : 0;
    const std::string word = reason_word(trial.reason);
    if (!trial.usable && (compared == Compared::kUsable || word != "sigma")) {
      ++row.reasons[word];
      continue;
    }
    ++row.usable;
    row.squares += trial.mahalanobis_squared;
    row.inside += trial.mahalanobis_squared < kChiSquare95 ? 1 : 0;
  }
  out << "\n| " << heading
      << " | trials | compared | surely wrong | mean squared Mahalanobis error / 6 | inside 95 % | "
         "refused for |\n|---|---|---|---|---|---|---|\n";
  for (const auto& [name, row] : rows) {
    out << "| " << name << " | " << row.trials << " | " << row.usable << " | " << row.wrong
        << " | ";
    if (row.usable > 0) out << std::round(100 * row.squares / (6 * row.usable)) / 100;
    out << " | ";
    if (row.usable > 0) out << row.inside << " of " << row.usable;
    out << " | ";
    const char* separator = "";
    for (const auto& [word, count] : row.reasons) {
      out << separator << word << ' ' << count;
      separator = ", ";
    }
    out << " |\n";
  }
}

}  // namespace

void write_summary(std::ostream& out, const std::vector<RigTrial>& trials) {
  const auto by_kind = [](const RigTrial& trial) {
    const std::string scenes = std::to_string(trial.scenes);
    return trial.kind + ", " + (scenes.size() < 2 ? " " : "") + scenes + " scenes";
  };
  write_table(out, "kind; usable", trials, by_kind);
  write_table(out, "kind; usable, or refused for sigma alone", trials, by_kind,
              Compared::kUsableOrImprecise);
  const auto right = [](const RigTrial& trial) { return trial.kind == "right"; };
  write_table(out, "right: lidar", trials,
              [&](const RigTrial& trial) { return right(trial) ? trial.lidar : ""; });
  write_table(out, "right: camera", trials, [&](const RigTrial& trial) {
    return !right(trial) ? ""
                         : std::to_string(trial.width) + " x " + std::to_string(trial.height) +
                               (trial.fisheye ? ", fisheye" : "");
  });
}

}  // namespace infuse::study
