#pragma once

#include <Eigen/Core>
#include <span>

#include "fusion/calibration/scene.hpp"

namespace infuse::calibration {

/// Computes what `scene_similarity` compares: fine structure of the first image feature that there
/// is (grey or edges less their surroundings), as a vector of length one; empty without an image.
Eigen::VectorXf make_signature(const Scene& scene);

/// Returns how much of two scenes is the same, for each pair: 0 for different places … 1 for the
/// same place seen again; a symmetric matrix with ones on its diagonal. Scenes of different cameras
/// count as different.
///
/// It is the correlation of the fine structure of the images, from which what different places
/// share by chance, or with a bonnet in view, is taken off. Road and sky are alike everywhere, and
/// are smooth. Ranges do not show a place: after 1 m of travel every beam hits something else.
Eigen::MatrixXd scene_similarity(std::span<const Scene> scenes);

/// Returns weights of scenes: wᵢ ∝ 1 / √Σⱼ sᵢⱼ, the largest 1. A compromise: equal weights minimise
/// the noise of the returns; 1 / Σⱼ sᵢⱼ would count each place once and minimise the error that
/// views of one place share.
Eigen::VectorXd scene_weights(const Eigen::MatrixXd& similarity);

/// Returns the number of independent scenes whose mean is as uncertain as that of scenes with these
/// weights and with their similarities as correlations: (Σ wᵢ)² / wᵀSw (Kish 1965). 0 for none.
double effective_scenes(const Eigen::MatrixXd& similarity, const Eigen::VectorXd& weights);

/// Returns the factor from the sum of the squared contributions of weighted scenes to the variance
/// of the contributions' sum: wᵀSw / wᵀw (design effect; Kish 1965). 1 for independent ones.
double design_effect(const Eigen::MatrixXd& similarity, const Eigen::VectorXd& weights);

}  // namespace infuse::calibration
