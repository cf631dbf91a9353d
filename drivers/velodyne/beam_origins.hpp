#pragma once

#include "drivers/velodyne/calibration.hpp"

namespace infuse::velodyne {

/// Distance, m, from a sensor's axis of the point where its beams cross, at the height of the
/// optical centre. A beam of elevation φ seems to start on the axis at the height −distance · tan
/// φ: the vertical offset of the manuals. 0 for an HDL-64E, whose units state their offsets.
///
/// - VLP-16, Puck Hi-Res: 41.9 mm, from the offsets of the manual 63-9243: 11.2 mm at −15° … −11.2
/// mm.
/// - VLP-32C: 42.4 mm and VLS-128: 58.63 mm, the focal distances of their manuals.
/// - HDL-32E: 29.0 mm, from the drawing 86-0106: +17.2 mm at −30.67°, −5.5 mm at 10.67°.
double crossing_distance(Model model);

/// Sets the vertical offsets of all beams from the crossing distance.
void add_beam_origins(Calibration& calibration, const ModelInfo& info);

/// The built-in calibration with all beams from one origin, as ROS drivers decode them.
Calibration single_origin_calibration(Model model);

}  // namespace infuse::velodyne
