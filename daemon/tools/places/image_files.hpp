#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/tools/places/place_list.hpp"
#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// The images of one drive.
struct ImageFiles {
  PlaceList list;
  double aspect = 1;  ///< width / height
};

/// Reads the images of a camera of a drive, or all .png, .jpg and .jpeg files of a folder in order
/// of their names, and passes each to `on_image`, grey. `camera` may be empty if there is one.
/// `aspect`, if given, is that of the drive with which these images are compared. Fails without
/// images, for images of different shapes, and if a file cannot be decoded.
Result<ImageFiles> read_image_files(const std::string& path, const std::string& camera,
                                    std::optional<double> aspect,
                                    const std::function<void(const CameraFrame&)>& on_image);

}  // namespace infuse::daemon
