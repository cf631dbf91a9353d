#include "fusion/calibration/compact_scene.hpp"

#include <memory>

#include "fusion/calibration/scene_images.hpp"
#include "fusion/calibration/scene_similarity.hpp"
#include "fusion/calibration/thin_scenes.hpp"

namespace infuse::calibration {

void compact_scene(Scene& scene, const RigCamera& camera, const Eigen::Isometry3d& T_refcam_lidar,
                   const CompactOptions& options) {
  scene.signature = std::make_shared<const Eigen::VectorXf>(make_signature(scene));
  scene.blurred = std::make_shared<const SceneImages>(scene.image, options.image,
                                                      sigmas_of(camera, options.blurs));
  scene.image = {};
  if (options.margin) keep_points_near(scene, camera, T_refcam_lidar, *options.margin);
}

}  // namespace infuse::calibration
