#include "fusion/target/find_boards.hpp"

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace infuse::target {
namespace {

std::vector<cv::Point2f> find_board(const cv::Mat& image, const Board& board) {
  std::vector<cv::Point2f> corners;
  const cv::Size size(board.columns, board.rows);
  // The accurate mode takes five times as long: use it only where there is a board.
  if (!cv::findChessboardCornersSB(image, size, corners)) return {};
  std::vector<cv::Point2f> accurate;
  if (cv::findChessboardCornersSB(image, size, accurate, cv::CALIB_CB_ACCURACY)) return accurate;
  return corners;
}

/// Covers a detected board, including its outermost squares, so that the next one is detected.
void mask_board(cv::Mat& image, const std::vector<cv::Point2f>& corners, const Board& board) {
  const auto at = [&](int row, int column) {
    return corners[static_cast<size_t>(row * board.columns + column)];
  };
  const int right = board.columns - 1;
  const int low = board.rows - 1;
  // One and a quarter squares beyond the outermost corners.
  const auto out = [&](int row, int column, int inner_row, int inner_column) {
    const cv::Point2f here = at(row, column);
    return cv::Point(here + 1.25F * (here - at(row, inner_column)) +
                     1.25F * (here - at(inner_row, column)));
  };
  const std::vector<cv::Point> outline = {out(0, 0, 1, 1), out(0, right, 1, right - 1),
                                          out(low, right, low - 1, right - 1),
                                          out(low, 0, low - 1, 1)};
  cv::fillConvexPoly(image, outline, cv::mean(image));
}

}  // namespace

std::vector<Corners> find_boards(const CameraFrame& grey, const Board& board, int max_boards) {
  std::vector<Corners> boards;
  if (grey.format != PixelFormat::kGrey8 || grey.width < 16 || grey.height < 16 ||
      grey.pixels.size() != grey.row_bytes() * static_cast<size_t>(grey.height)) {
    return boards;
  }
  cv::setNumThreads(1);
  cv::Mat image(grey.height, grey.width, CV_8UC1);
  std::copy(grey.pixels.begin(), grey.pixels.end(), image.data);
  try {
    while (static_cast<int>(boards.size()) < max_boards) {
      const std::vector<cv::Point2f> found = find_board(image, board);
      if (found.size() != board.corner_count()) break;
      Corners& corners = boards.emplace_back();
      for (const cv::Point2f& corner : found) {
        corners.emplace_back(double{corner.x}, double{corner.y});
      }
      mask_board(image, found, board);
    }
  } catch (const cv::Exception&) {
    // The detector failed on this image; keep the boards found before.
  }
  return boards;
}

}  // namespace infuse::target
