#include "daemon/view/view_profiler.hpp"

#include <cmath>

#include "daemon/protocol/json.hpp"
#include "daemon/view/view_frames.hpp"
#include "drivers/camera/colour.hpp"

namespace infuse::daemon {
namespace {

constexpr double kNatsStep = 1e-6;  // of the numbers that are sent

Json to_json(const monitoring::DependenceProfile& profile) {
  Json axes = Json::array();
  for (const auto& values : profile.nats) {
    Json& axis = axes.emplace_back(Json::array());
    for (const double nats : values) axis.push_back(std::round(nats / kNatsStep) * kNatsStep);
  }
  return axes;
}

}  // namespace

ViewProfiler::ViewProfiler(const Rig& rig) : rig_(rig) {
  for (const CameraMount& camera : rig.cameras) {
    samplers_.emplace_back(camera.intrinsics, monitoring::ProfileOptions{});
  }
}

std::string ViewProfiler::encode(const ViewImage& image) {
  const CameraMount& camera = rig_.cameras[image.camera];
  monitoring::ProfileSampler& sampler = samplers_[image.camera];
  camera::to_grey(image.frame, grey_);
  const char* reason = sampler.prepare(grey_, image.returns.view(), image.T_camera_lidar);
  Json profiles = Json::object();
  if (*reason == '\0') {
    const auto add = [&](const char* name, const Eigen::Isometry3d& T_camera_lidar) {
      for (const auto& [other, pose] :
           {std::pair("saved", &camera.T_camera_lidar), std::pair("use", &image.T_camera_lidar)}) {
        if (profiles.contains(other) && pose->matrix() == T_camera_lidar.matrix()) {
          profiles[name] = Json(profiles[other]);
          return;
        }
      }
      profiles[name] = to_json(sampler.sample(T_camera_lidar));
    };
    add("use", image.T_camera_lidar);
    add("saved", camera.T_camera_lidar);
    if (image.T_camera_lidar_estimate) add("estimate", *image.T_camera_lidar_estimate);
  }
  return encode_frame({{"kind", "profile"},
                       {"device", camera.name},
                       {"stamp", std::to_string(image.frame.stamp.ns())},
                       {"points", 0},
                       {"reason", reason},
                       {"rotation", sampler.options().rotation},
                       {"translation", sampler.options().translation},
                       {"profiles", std::move(profiles)}});
}

}  // namespace infuse::daemon
