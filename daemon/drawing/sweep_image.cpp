#include "daemon/drawing/sweep_image.hpp"

#include <algorithm>
#include <cmath>

#include "daemon/drawing/view_from_above.hpp"

namespace infuse::daemon {
namespace {

void draw_points(TwoViewsFromAbove& views, int view, const Sweep& sweep,
                 const FieldVector<float>& x, const FieldVector<float>& y,
                 const FieldVector<float>& z) {
  const float span = std::max(1.0F, static_cast<float>(sweep.span.count()));
  for (size_t i = 0; i < x.size(); ++i) {
    const float offset = sweep.has_times ? static_cast<float>(sweep.time_offset_ns[i]) : 0;
    views.draw(view, x[i], y[i], z[i], fraction_colour(offset / span));
  }
}

}  // namespace

CameraFrame draw_sweep(const Sweep& sweep, const motion::DeskewedSweep& deskewed) {
  TwoViewsFromAbove views({"as measured", "deskewed"}, {{"start of turn", fraction_colour(0)},
                                                        {"end of turn", fraction_colour(1)}});
  draw_points(views, 0, sweep, sweep.x, sweep.y, sweep.z);
  draw_points(views, 1, sweep, deskewed.x, deskewed.y, deskewed.z);
  return views.take();
}

CameraFrame draw_alignment(const Sweep& target, const Sweep& source,
                           const Eigen::Isometry3d& T_before, const Eigen::Isometry3d& T_after) {
  // Blue and orange, which the colour-blind tell apart (Okabe and Ito, 2008).
  constexpr Colour kTarget{233, 180, 86}, kSource{0, 159, 230};
  TwoViewsFromAbove views({"before", "after"}, {{"target", kTarget}, {"source", kSource}});
  for (const int view : {0, 1}) {
    for (size_t i = 0; i < target.size(); ++i) {
      views.draw(view, target.x[i], target.y[i], target.z[i], kTarget);
    }
    const Eigen::Isometry3f T = (view == 0 ? T_before : T_after).cast<float>();
    for (size_t i = 0; i < source.size(); ++i) {
      const Eigen::Vector3f p = T * Eigen::Vector3f(source.x[i], source.y[i], source.z[i]);
      views.draw(view, p.x(), p.y(), p.z(), kSource);
    }
  }
  return views.take();
}

}  // namespace infuse::daemon
