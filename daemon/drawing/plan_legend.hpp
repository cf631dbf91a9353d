#pragma once

#include <vector>

#include "daemon/drawing/view_from_above.hpp"
#include "drivers/measurement/camera_frame.hpp"

namespace infuse::daemon {

/// What a reader of a plan needs.
struct PlanLegend {
  double metres_per_pixel = 1;
  bool north_up = false;
  std::vector<ColourMeaning> colours;
};

/// Adds a strip below an image in kBgr8: a scale bar of a round length with its metres, "north up",
/// and what the colours mean, in as many lines as the width needs. The plan itself is unchanged. An
/// image that is narrower than 100 pixels stays as it is.
void add_legend(CameraFrame& image, const PlanLegend& legend);

}  // namespace infuse::daemon
