#include "fusion/registration/nearest_pairs.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/registration/move_points.hpp"

namespace infuse::registration {
namespace {

using features::NearestOfEach;
using features::NearestQueries;

// A search also bounds the other points' distances, by so much beyond the nearest one's: what the
// points are expected to move in the iterations to come, in units of the last move, at most …
// No result depends on either, which bounds time.
constexpr double kMarginPerMove = 0.6;
constexpr double kMaxMargin = 0.2;  // m; bounds time

}  // namespace

void NearestPairs::begin(const PointCloud& source) {
  pairs_.resize(source.size());
  for (Pairs::Field* field : {&searched_x_, &searched_y_, &searched_z_, &slack_}) {
    field->assign(source.size(), 0.0F);
  }
  index_.assign(source.size(), -1);
  for (Pairs::Field* field :
       {&pairs_.qx, &pairs_.qy, &pairs_.qz, &pairs_.tx, &pairs_.ty, &pairs_.tz}) {
    std::fill(field->begin(), field->end(), 0.0F);
  }
}

void NearestPairs::search(const PreparedCloud& target, size_t begin, float max_distance,
                          float margin) {
  const size_t end = std::min(begin + kLanes, pairs_.size);
  NearestQueries queries{{}, Floats{} - 1};
  bool any = false;
  for (size_t i = begin; i < end; ++i) {
    const float p[3] = {pairs_.px[i], pairs_.py[i], pairs_.pz[i]};
    const float mx = p[0] - searched_x_[i], my = p[1] - searched_y_[i], mz = p[2] - searched_z_[i];
    // Another point can be nearer only after a move of half the difference of the two distances.
    if (mx * mx + my * my + mz * mz < slack_[i] * slack_[i]) continue;
    float reach = max_distance;
    if (index_[i] >= 0) {  // the nearest one is no farther than the former one is now
      const float x = pairs_.qx[i] - p[0], y = pairs_.qy[i] - p[1], z = pairs_.qz[i] - p[2];
      reach = std::min(reach, 1e-4F + std::sqrt(x * x + y * y + z * z));
    }
    const auto lane = static_cast<int>(i - begin);
    for (int axis = 0; axis < 3; ++axis) queries.at[axis][lane] = p[axis];
    queries.max_distance[lane] = reach;
    any = true;
  }
  if (!any) return;
  const NearestOfEach nearest = target.search.nearest_of_each(queries, margin);
  for (size_t i = begin; i < end; ++i) {
    const auto lane = static_cast<int>(i - begin);
    if (queries.max_distance[lane] < 0) continue;
    searched_x_[i] = pairs_.px[i], searched_y_[i] = pairs_.py[i], searched_z_[i] = pairs_.pz[i];
    index_[i] = nearest.index[lane];
    if (index_[i] < 0) {
      slack_[i] = std::max(nearest.others[lane] - max_distance, 0.0F);
    } else {
      slack_[i] = 0.5F * (nearest.others[lane] - std::sqrt(nearest.square_distance[lane]));
      const auto j = static_cast<size_t>(index_[i]);
      pairs_.qx[i] = target.cloud.x[j];
      pairs_.qy[i] = target.cloud.y[j];
      pairs_.qz[i] = target.cloud.z[j];
      pairs_.tx[i] = target.cloud.nx[j];
      pairs_.ty[i] = target.cloud.ny[j];
      pairs_.tz[i] = target.cloud.nz[j];
    }
  }
}

size_t NearestPairs::match(const PreparedCloud& target, const PointCloud& source,
                           const Eigen::Isometry3d& T_target_source, double max_distance,
                           double last_move) {
  move_points(T_target_source, source.points(), pairs_.px, pairs_.py, pairs_.pz);
  Eigen::Isometry3d R = T_target_source;
  R.translation().setZero();
  move_points(R, {source.nx, source.ny, source.nz}, pairs_.sx, pairs_.sy, pairs_.sz);
  const auto limit = static_cast<float>(max_distance);
  const auto margin = static_cast<float>(std::min(kMarginPerMove * last_move, kMaxMargin));
  for (size_t begin = 0; begin < pairs_.size; begin += kLanes) {
    search(target, begin, limit, margin);
  }
  size_t found = 0;
  for (size_t i = 0; i < pairs_.size; ++i) {
    const float dx = pairs_.qx[i] - pairs_.px[i], dy = pairs_.qy[i] - pairs_.py[i],
                dz = pairs_.qz[i] - pairs_.pz[i];
    const bool paired = index_[i] >= 0 && dx * dx + dy * dy + dz * dz <= limit * limit;
    pairs_.weight[i] = paired ? 1.0F : 0.0F;
    found += paired ? 1 : 0;
  }
  return found;
}

}  // namespace infuse::registration
