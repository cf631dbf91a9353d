#include "tests/study/rigs/rig_study.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <ostream>
#include <random>

#include "drivers/measurement/angles.hpp"
#include "fusion/calibration/calibrate.hpp"

namespace infuse::study {
namespace {

using calibration::RigCamera;
using calibration::Scene;
using geometry::Vector6;

constexpr double kChiSquare997 = 19.8;  // 99.7 % of 6 degrees of freedom
constexpr double kLateSeconds = 0.1;
constexpr double kStartAngle = 2 * kDegree, kStartLength = 0.08;

/// A kind of trial: which scenes, and what is done to the camera and to them.
struct Kind {
  const char* name;
  size_t scenes;
  bool quick;  // part of a quick study
  void (*change)(CameraIntrinsics& camera, std::vector<RigScene>& scenes) = nullptr;
  bool neighbours = false;
};

void raise_centre(CameraIntrinsics& camera, std::vector<RigScene>&) {
  camera.cy += 0.024 * camera.width;
}
void shorten_focal(CameraIntrinsics& camera, std::vector<RigScene>&) {
  camera.fx *= 0.97;
  camera.fy *= 0.97;
}
void drop_distortion(CameraIntrinsics& camera, std::vector<RigScene>&) { camera.distortion = {}; }
void shuffle_images(CameraIntrinsics&, std::vector<RigScene>& scenes) {
  for (size_t k = 0; k + 3 < scenes.size(); ++k) std::swap(scenes[k].frame, scenes[k + 3].frame);
}
/// Sweeps as of a moment before the exposure.
void delay_images(CameraIntrinsics&, std::vector<RigScene>& scenes) {
  for (RigScene& scene : scenes) {
    const Eigen::Isometry3d there = geometry::exp(kLateSeconds * scene.twist);
    for (size_t i = 0; i < scene.sweep.size(); ++i) {
      const Eigen::Vector3d p =
          there * Eigen::Vector3d(scene.sweep.x[i], scene.sweep.y[i], scene.sweep.z[i]);
      scene.sweep.x[i] = static_cast<float>(p.x());
      scene.sweep.y[i] = static_cast<float>(p.y());
      scene.sweep.z[i] = static_cast<float>(p.z());
    }
  }
}
/// The first place again and again, with noise of ranges and pixels.
void stand_still(CameraIntrinsics&, std::vector<RigScene>& scenes) {
  std::mt19937_64 random(1);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-52 - 1; };
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

constexpr Kind kKinds[] = {
    {"right", 20, true},
    {"right", 10, false},
    {"right", 5, true},
    {"right", 3, false},
    {"neighbours", 8, false, nullptr, true},
    {"cy + 2.4 % of the width", 20, true, raise_centre},
    {"f - 3 %", 20, true, shorten_focal},
    {"distortion left out", 20, true, drop_distortion},
    {"images of other places", 20, true, shuffle_images},
    {"images 0.1 s late", 20, true, delay_images},
    {"one standing place", 20, false, stand_still},
};

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

RigTrial try_kind(const RigRecording& recording, const Kind& kind, uint64_t seed) {
  const std::vector<RigScene>& from = kind.neighbours ? recording.neighbours : recording.diverse;
  std::vector<RigScene> recorded;
  const size_t count = std::min(kind.scenes, from.size());
  for (size_t k = 0; k < count; ++k) {
    recorded.push_back(from[(2 * k + 1) * from.size() / (2 * count)]);
  }
  CameraIntrinsics stated = recording.camera;
  if (kind.change != nullptr) kind.change(stated, recorded);
  std::mt19937_64 random(seed);
  Vector6 off;
  for (int k = 0; k < 6; ++k) {
    const double uniform = static_cast<double>(random() >> 11) * 0x1p-52 - 1.0;
    off(k) = uniform * (k < 3 ? kStartAngle : kStartLength);
  }
  const Eigen::Isometry3d initial = geometry::exp(off) * recording.T_camera_lidar;
  const std::vector<RigCamera> cameras{{geometry::CameraModel(stated)}};
  const std::vector<Scene> scenes = make_scenes(recorded, cameras[0], initial);
  const std::clock_t began = std::clock();
  const calibration::CalibrationResult result =
      calibration::calibrate(scenes, cameras, initial, {.seed = seed});
  RigTrial trial{.seed = seed,
                 .kind = kind.name,
                 .lidar = recording.lidar,
                 .width = stated.width,
                 .height = stated.height,
                 .fisheye = stated.model == CameraIntrinsics::Model::kFisheye,
                 .scenes = scenes.size(),
                 .effective_scenes = result.uncertainty.effective_scenes,
                 .usable = result.usable(),
                 .reason = result.reason};
  trial.cpu_s = static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
  const Vector6 error = geometry::log(recording.T_camera_lidar * result.T_refcam_lidar.inverse());
  trial.rotation_error = error.head<3>().norm();
  trial.translation_error =
      (recording.T_camera_lidar.translation() - result.T_refcam_lidar.translation()).norm();
  const geometry::Matrix6 covariance = result.covariance();
  trial.rotation_sigma = std::sqrt(covariance.diagonal().head<3>().maxCoeff());
  trial.translation_sigma = std::sqrt(covariance.diagonal().tail<3>().maxCoeff());
  trial.mahalanobis_squared = error.dot(covariance.inverse() * error);
  trial.scenes_mahalanobis_squared = error.dot(result.uncertainty.covariance.inverse() * error);
  return trial;
}

}  // namespace

bool RigTrial::surely_wrong() const {
  return usable && (rotation_error > 0.2 * kDegree || translation_error > 0.05) &&
         mahalanobis_squared > kChiSquare997;
}

std::vector<RigTrial> try_rig(const RigRecording& recording, uint64_t seed, bool quick) {
  std::vector<RigTrial> trials;
  for (const Kind& kind : kKinds) {
    if (!quick || kind.quick) trials.push_back(try_kind(recording, kind, seed));
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

void write_summary(std::ostream& out, const std::vector<RigTrial>& trials) {
  struct Row {
    int trials = 0, usable = 0, wrong = 0;
    double squares = 0;
  };
  std::map<std::pair<std::string, size_t>, Row> rows;
  for (const RigTrial& trial : trials) {
    Row& row = rows[{trial.kind, trial.scenes}];
    ++row.trials;
    row.usable += trial.usable ? 1 : 0;
    row.wrong += trial.surely_wrong() ? 1 : 0;
    if (trial.usable) row.squares += trial.mahalanobis_squared;
  }
  out << "| kind | scenes | trials | usable | surely wrong | mean squared Mahalanobis error / 6 |\n"
         "|---|---|---|---|---|---|\n";
  for (const auto& [key, row] : rows) {
    out << "| " << key.first << " | " << key.second << " | " << row.trials << " | " << row.usable
        << " | " << row.wrong << " | ";
    if (row.usable > 0) out << row.squares / (6 * row.usable);
    out << " |\n";
  }
}

}  // namespace infuse::study
