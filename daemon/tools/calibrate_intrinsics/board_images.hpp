#pragma once

#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"
#include "fusion/target/board.hpp"
#include "fusion/target/find_boards.hpp"

namespace infuse::daemon {

/// Views of a board in the images of one camera.
struct BoardImages {
  size_t images = 0;                   ///< number of files that were read
  int width = 0, height = 0;           ///< pixels; of all views
  std::vector<target::Corners> views;  ///< of the board
  std::vector<std::string> names;      ///< one per view
  std::vector<std::string> skipped;    ///< images without a view, and why
  std::string camera;                  ///< name of a drive's camera; empty: folders of images
  Rig rig;                             ///< of the first drive
};

/// Finds the board in drives and folders of images, all of one camera. Of a drive, images 0.5 s
/// apart are searched; a damaged file, an image without a board and one of another size than most
/// are skipped. Errors: a drive or folder that cannot be read, or has no images.
Result<BoardImages> find_board_images(const std::vector<std::string>& inputs,
                                      const std::string& camera, const target::Board& board);

}  // namespace infuse::daemon
