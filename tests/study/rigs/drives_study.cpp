#include "tests/study/rigs/drives_study.hpp"

#include <cmath>
#include <istream>
#include <ostream>
#include <random>
#include <span>
#include <sstream>

#include "drivers/measurement/angles.hpp"
#include "fusion/geometry/draw_uniform.hpp"
#include "tests/study/rigs/rig_recording.hpp"
#include "tests/study/rigs/rig_study.hpp"

namespace infuse::study {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

constexpr double kChiSquareOfSix99 = 16.81;      // 99 % of 6 degrees of freedom
constexpr uint64_t kWorldSeeds = 1'000'000'000;  // from there on, none of a rig's

/// A calibration of one drive.
struct Outcome {
  calibration::CalibrationResult result;
  Vector6 error = Vector6::Zero();  // T_true = exp(error) T
};

/// Change of the result by one standard deviation of each of the four intrinsics.
Eigen::Matrix<double, 6, 4> by_intrinsics(const calibration::CalibrationResult& result) {
  Eigen::Matrix<double, 6, 4> moved;
  for (size_t k = 0; k < 4; ++k) {
    const calibration::ParameterCheck& one = result.parameter_checks[k];
    moved.col(static_cast<Eigen::Index>(k)) = one.known_sigma * one.pose_sensitivity;
  }
  return moved;
}

/// Covariance of the difference of two results with the same intrinsics: scenes and clocks of each,
/// and what the intrinsics' errors move the one more than the other.
Matrix6 covariance_between(const Outcome& a, const Outcome& b) {
  Matrix6 sum = a.result.uncertainty.covariance + b.result.uncertainty.covariance;
  const Eigen::Matrix<double, 6, 4> apart = by_intrinsics(a.result) - by_intrinsics(b.result);
  sum += apart * apart.transpose();
  for (const Outcome* one : {&a, &b}) {
    if (one->result.parameter_checks.size() < 5) continue;
    const calibration::ParameterCheck& clock = one->result.parameter_checks[4];
    const Vector6 moved = clock.known_sigma * clock.pose_sensitivity;
    sum += moved * moved.transpose();
  }
  return sum;
}

Outcome calibrate_drive(RigRecording& recording, const CameraIntrinsics& stated, uint64_t seed,
                        std::mt19937_64& random) {
  draw_known_errors(recording.diverse, random);
  Vector6 off;
  for (int i = 0; i < 6; ++i) {
    off(i) = geometry::draw_uniform(random) * (i < 3 ? 2 * kDegree : 0.08);
  }
  const Eigen::Isometry3d initial = geometry::exp(off) * recording.T_camera_lidar;
  const calibration::RigCamera camera{geometry::CameraModel(stated)};
  const auto scenes = make_scenes(recording.diverse, camera, initial);
  Outcome out;
  out.result = calibration::calibrate(scenes, std::span(&camera, 1), initial, {.seed = seed});
  out.error = geometry::log(recording.T_camera_lidar * out.result.T_refcam_lidar.inverse());
  return out;
}

}  // namespace

std::optional<DrivesTrial> drive_twice(uint64_t seed, const DrivesOptions& options) {
  std::mt19937_64 random(seed);
  DrivesTrial trial{.seed = seed};
  CameraIntrinsics stated;
  std::array<Outcome, 2> outcomes;
  for (size_t k = 0; k < outcomes.size(); ++k) {
    auto recording = record_random_rig(seed, {.diverse = options.scenes,
                                              .neighbours = 0,
                                              .duration = options.seconds,
                                              .world = (k + 1) * kWorldSeeds + seed});
    if (!recording) return std::nullopt;
    if (k == 0) {
      stated = recording->camera;
      draw_known_errors(stated, random);
      trial.lidar = recording->lidar;
    }
    outcomes[k] = calibrate_drive(*recording, stated, seed, random);
    const calibration::CalibrationResult& result = outcomes[k].result;
    const Vector6& error = outcomes[k].error;
    trial.from_truth2[k] = error.dot(result.covariance().inverse() * error);
    trial.usable += result.usable() ? 1 : 0;
    if (trial.reason.empty()) trial.reason = result.reason;
  }
  trial.width = stated.width;
  trial.fisheye = stated.model == CameraIntrinsics::Model::kFisheye;
  const Vector6 apart = outcomes[0].error - outcomes[1].error;
  trial.rotation = apart.head<3>().norm();
  trial.translation = apart.tail<3>().norm();
  if (trial.usable == 2) {
    trial.mahalanobis2 = apart.dot(covariance_between(outcomes[0], outcomes[1]).inverse() * apart);
  }
  return trial;
}

void write_drives_header(std::ostream& out) {
  out << "seed,lidar,width,fisheye,usable,rotation_deg,translation_cm,mahalanobis2,"
         "mahalanobis2_first,mahalanobis2_second,reason\n";
}

void write_drives_row(std::ostream& out, const DrivesTrial& t) {
  out << t.seed << ',' << t.lidar << ',' << t.width << ',' << t.fisheye << ',' << t.usable << ','
      << t.rotation / kDegree << ',' << 100 * t.translation << ',' << t.mahalanobis2 << ','
      << t.from_truth2[0] << ',' << t.from_truth2[1] << ",\"" << t.reason << "\"\n";
}

std::vector<DrivesTrial> read_drives_rows(std::istream& in) {
  std::vector<DrivesTrial> trials;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line.front() < '0' || line.front() > '9' || line.back() != '"') continue;
    std::istringstream cells(line);
    DrivesTrial t;
    char comma = 0;
    cells >> t.seed >> comma;
    std::getline(cells, t.lidar, ',');
    cells >> t.width >> comma >> t.fisheye >> comma >> t.usable >> comma >> t.rotation >> comma >>
        t.translation >> comma >> t.mahalanobis2 >> comma >> t.from_truth2[0] >> comma >>
        t.from_truth2[1] >> comma;
    if (!cells) continue;
    std::getline(cells, t.reason);
    t.reason = t.reason.substr(1, t.reason.size() - 2);
    t.rotation *= kDegree;
    t.translation /= 100;
    trials.push_back(t);
  }
  return trials;
}

void write_drives_summary(std::ostream& out, const std::vector<DrivesTrial>& trials) {
  for (const bool fisheye : {false, true}) {
    int rigs = 0, usable = 0, pairs = 0, beyond = 0;
    double squares = 0;
    for (const DrivesTrial& trial : trials) {
      if (trial.fisheye != fisheye) continue;
      ++rigs;
      usable += trial.usable;
      if (trial.usable < 2) continue;
      ++pairs;
      squares += trial.mahalanobis2;
      beyond += trial.mahalanobis2 > kChiSquareOfSix99 ? 1 : 0;
    }
    out << (fisheye ? "fisheye" : "pinhole") << ": " << usable << " of " << 2 * rigs
        << " drives usable; " << pairs << " rigs with both, M2/6 of the difference "
        << (pairs > 0 ? std::round(100 * squares / (6 * pairs)) / 100 : 0) << ", " << beyond
        << " beyond 99 %\n";
  }
}

}  // namespace infuse::study
