#pragma once

#include <Eigen/Core>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "fusion/target/board.hpp"

namespace infuse::target {

/// The inner corners of one board in a picture: pixels, in the order of `Board::corner`.
using Corners = std::vector<Eigen::Vector2d>;

/// Every board of this kind in a grey picture (kGrey8), at most `most`, by OpenCV's detector of
/// chessboard corners. Which end of a board is counted first is not determined where the board
/// looks alike from both. Nothing where none is found, or the picture is not grey.
std::vector<Corners> find_boards(const CameraFrame& grey, const Board& board, int max_boards);

}  // namespace infuse::target
