#pragma once

#include <Eigen/Core>
#include <span>

#include "fusion/calibration/scene.hpp"

namespace infuse::calibration {

/// Fine structure of a scene, each as a vector of length one (or zero).
struct SceneSignature {
  Eigen::VectorXf image;
  Eigen::VectorXf returns;
};

/// Computes what `scene_similarity` compares.
SceneSignature make_signature(const Scene& scene);

/// Returns how much of two scenes is the same, for each pair: 0 for different places … 1 for the
/// same place seen again; a symmetric matrix with ones on its diagonal. Scenes of different cameras
/// count as different.
///
/// Compared are the fine structure of the images (grey or edges less their surroundings) and of the
/// returns (inverse ranges over the directions, less those around): the geometric mean of their two
/// correlations, from which what different places share by chance is taken off. Road and sky are
/// alike everywhere, and are smooth.
Eigen::MatrixXd scene_similarity(std::span<const Scene> scenes);

/// Returns the number of independent scenes whose mean is as uncertain as that of scenes with these
/// similarities as correlations: n² / Σᵢⱼ wᵢⱼ (design effect; Kish 1965). 0 for none.
double effective_scenes(const Eigen::MatrixXd& similarity);

}  // namespace infuse::calibration
