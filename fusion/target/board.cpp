#include "fusion/target/board.hpp"

#include <cmath>
#include <cstdio>

namespace infuse::target {

std::optional<std::string> Board::invalid() const {
  if (columns < 3 || rows < 3 || columns > 100 || rows > 100) {
    return "a board must have 3 to 100 inner corners per row and per column";
  }
  if (!(square_size > 0) || !std::isfinite(square_size)) return "square_size must be positive";
  return std::nullopt;
}

bool Board::set_corners(const std::string& text) {
  int end = 0;
  return std::sscanf(text.c_str(), "%dx%d%n", &columns, &rows, &end) == 2 &&
         static_cast<size_t>(end) == text.size();
}

Eigen::Vector3d Board::corner(size_t index) const {
  const auto across = static_cast<size_t>(columns);
  return {square_size * static_cast<double>(index % across),
          square_size * static_cast<double>(index / across), 0};
}

Eigen::Vector3d Board::middle() const {
  return {0.5 * square_size * (columns - 1), 0.5 * square_size * (rows - 1), 0};
}

Eigen::Vector3d Board::bow_at(const Eigen::Vector2d& at) const {
  // mean of x² over n evenly spaced corners that reach (n − 1) / (n + 1) of the half size
  const auto mean = [](int n) { return (n - 1.0) / (3 * (n + 1.0)); };
  return {at.x() * at.x() - mean(columns), at.x() * at.y(), at.y() * at.y() - mean(rows)};
}

Eigen::Vector2d Board::half_size() const {
  return {0.5 * square_size * (columns + 1), 0.5 * square_size * (rows + 1)};
}

}  // namespace infuse::target
