#pragma once

#include <Eigen/Core>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "fusion/target/board.hpp"

namespace infuse::target {

/// Inner corners of one board in an image: pixels, in the order of `Board::corner`.
using Corners = std::vector<Eigen::Vector2d>;

/// Finds up to `max_boards` boards of this kind in a grey image (kGrey8) with OpenCV's chessboard
/// corner detector. For a board that is symmetric under a half turn, which corner comes first is
/// arbitrary. Returns an empty list if there is no board or the image is not grey.
std::vector<Corners> find_boards(const CameraFrame& grey, const Board& board, int max_boards);

}  // namespace infuse::target
