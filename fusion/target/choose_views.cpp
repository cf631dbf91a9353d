#include "fusion/target/choose_views.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace infuse::target {
namespace {

double corner_motion(const Corners& a, const Corners& b) {
  double same = 0, turned = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    same += (a[i] - b[i]).squaredNorm();
    turned += (a[i] - b[b.size() - 1 - i]).squaredNorm();
  }
  return std::sqrt(std::min(same, turned) / static_cast<double>(std::max<size_t>(1, a.size())));
}

}  // namespace

std::vector<size_t> choose_views(std::span<const Corners> views, size_t max_views,
                                 double min_motion) {
  std::vector<size_t> chosen;
  std::vector<double> motion(views.size(), std::numeric_limits<double>::infinity());
  while (chosen.size() < std::min(max_views, views.size())) {
    const auto next = std::ranges::max_element(motion);
    if (!(*next >= min_motion)) break;
    chosen.push_back(static_cast<size_t>(next - motion.begin()));
    for (size_t v = 0; v < views.size(); ++v)
      motion[v] = std::min(motion[v], corner_motion(views[v], views[chosen.back()]));
    motion[chosen.back()] = -1;
  }
  std::ranges::sort(chosen);
  return chosen;
}

}  // namespace infuse::target
