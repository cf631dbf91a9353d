// A registration factor and a measure of dependence of your own, for your_own.py:
//   g++ -std=c++20 -O2 -Wno-psabi -shared -fPIC your_own.cpp -o your_own.so $(pkg-config --cflags
//   --libs infuse)

#include <algorithm>
#include <array>
#include <infuse/registration.hpp>

namespace {

/// The distance of a point from the target's plane, with Cauchy's weight 1 / (1 + d² / width²).
/// Points on things that moved between the two scans get little weight. All else is inherited.
struct CauchyPlane : infuse::registration::PointToPlaneFactor {
  double width = 0.1;  // m

  template <class Number>
  [[gnu::always_inline]] Number weight(const Number& square) const {
    using Scalar = infuse::registration::ScalarOf<Number>;
    const auto width2 = static_cast<Scalar>(width * width);
    return width2 / (square + width2);
  }
};

infuse::registration::PreparedCloud prepare(const float* xyz, size_t n) {
  infuse::FieldVector<float> x(n), y(n), z(n);
  for (size_t k = 0; k < n; ++k, xyz += 3) x[k] = xyz[0], y[k] = xyz[1], z[k] = xyz[2];
  return infuse::registration::prepare_cloud({x, y, z});
}

}  // namespace

// Points: n × 3. pose: T_target_source, 16 numbers by row. Returns why it cannot be used, or "".
extern "C" const char* align_by_cauchy(const float* target, size_t n, const float* source, size_t m,
                                       double* pose) {
  infuse::registration::Registration<CauchyPlane> registration;
  const auto to = prepare(target, n), from = prepare(source, m);
  const auto result = registration.align(to, from.cloud, Eigen::Isometry3d::Identity());
  Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>{pose} = result.T_target_source.matrix();
  return result.reason;
}

// The correlation ratio: the share of the variance of y, 0 ... 1, that x explains by one of 16
// levels.
extern "C" double correlation_ratio(const float* x, const float* y, size_t n) {
  struct Level {
    double count = 0, sum = 0;
  };
  std::array<Level, 16> levels;
  double sum = 0, squares = 0, explained = 0;
  for (size_t k = 0; k < n; ++k) {
    Level& level = levels[static_cast<size_t>(std::clamp(16 * x[k], 0.0F, 15.0F))];
    level.count += 1, level.sum += y[k];
    sum += y[k], squares += double{y[k]} * y[k];
  }
  const double mean = sum / static_cast<double>(n);
  for (const Level& level : levels) {
    if (level.count > 0) explained += level.sum * level.sum / level.count;
  }
  return (explained - sum * mean) / (squares - sum * mean);
}
