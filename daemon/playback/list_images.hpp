#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"

namespace infuse::daemon {

/// An image file, and its stamp where it is known.
struct ImageFile {
  std::filesystem::path path;
  std::optional<Stamp> stamp;
};

/// The image files of one camera.
struct ImageList {
  std::vector<ImageFile> files;       ///< in order of time, or of their names
  std::string camera;                 ///< name of a drive's camera; empty: a folder of images
  std::optional<PixelFormat> mosaic;  ///< Bayer pattern of a drive's raw images
  Rig rig;                            ///< of a drive
};

/// Returns the index of the camera of that name, or of the only one if `name` is empty. `where` is
/// what the error names.
Result<size_t> find_camera(const Rig& rig, const std::string& name, const std::string& where);

/// Lists the images of a camera of a drive, or all .png, .jpg and .jpeg files of a folder. `camera`
/// may be empty if there is one. Fails without images.
Result<ImageList> list_images(const std::filesystem::path& path, const std::string& camera);

}  // namespace infuse::daemon
