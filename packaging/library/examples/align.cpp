#include <cstdio>
#include <infuse/registration.hpp>

int main() {
  std::vector<Eigen::Vector3f> target, source;  // a corner of a room, from two places
  for (int i = 0; i < 10000; ++i) {
    const float a = 0.1F * static_cast<float>(i % 100), b = 0.1F * static_cast<float>(i / 100);
    for (const Eigen::Vector3f& p : {Eigen::Vector3f(a, b, 0), {a, 10, b}, {10, a, b}}) {
      target.push_back(p), source.push_back(p - Eigen::Vector3f(0.3F, 0, 0));
    }
  }
  const auto result = infuse::registration::align_points(target, source);
  std::printf("%.2f m along x %s\n", result.T_target_source.translation().x(), result.reason);
  return result.usable() ? 0 : 1;
}
