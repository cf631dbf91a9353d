#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"
#include "fusion/places/image_descriptor.hpp"

namespace infuse::daemon {

/// Images of one drive, described.
struct ImageDrive {
  std::vector<std::string> names;  ///< file names
  std::vector<Stamp> stamps;       ///< empty for a folder of images
  std::vector<places::ImageDescriptor> descriptors;
  double aspect = 1;  ///< width / height
};

/// Reads the images of a camera of a drive, or all .png, .jpg and .jpeg files of a folder in order
/// of their names, and describes each, reduced to 64 pixels across; what all have in common is
/// removed. `camera` may be empty if there is one. `aspect`, if given, is that of the drive with
/// which these images are compared. Fails without images, for images of different shapes, and if a
/// file cannot be decoded.
Result<ImageDrive> read_image_drive(const std::string& path, const std::string& camera,
                                    std::optional<double> aspect = std::nullopt);

}  // namespace infuse::daemon
