#pragma once

#include "fusion/dependence/least_squares.hpp"
#include "tests/fusion/streetmap/town.hpp"

namespace infuse::streetmap::town {

/// Small grids of hyper-parameters, for quick tests.
inline const dependence::FitOptions kFit{
    .centres = 25, .sigmas = {1.0, 2.0}, .lambdas = {1e-3, 1e-1}};

/// A view of the town and its true labels.
struct LabelledView {
  Town town = build(plan());
  PlanarPose pose{-60, 0, 0};
  GridSamples samples = sample_view(town.map, pose, 1);
  LabelWindow window;
  std::vector<int32_t> labels = std::vector<int32_t>(samples.size());

  LabelledView() {
    window.read(town.map, pose.x, pose.y, 60, Labelling::kKinds);
    window.look_up(pose, samples.x, samples.y, labels);
  }
};

}  // namespace infuse::streetmap::town
