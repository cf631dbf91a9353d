// Aligns two scans of a room: floor and two walls, the second scan from 0.3 m further along x.
#include <cstdio>
#include <infuse/registration.hpp>

infuse::registration::PreparedCloud scan(float from) {
  infuse::FieldVector<float> x, y, z;
  for (int i = 0; i < 30000; ++i) {
    const float a = 0.1f * static_cast<float>(i % 100) + 0.2f * from;
    const float b = 0.1f * static_cast<float>(i / 100 % 100);
    const int side = i / 10000;
    x.push_back((side == 2 ? 10 : a) - from);
    y.push_back(side == 1 ? 10 : b);
    z.push_back(side == 0 ? 0 : side == 1 ? b : a);
  }
  return infuse::registration::prepare_cloud({x, y, z});
}

int main() {
  const auto first = scan(0), second = scan(0.3f);
  const auto guess = Eigen::Isometry3d::Identity();
  const auto result = infuse::registration::gicp(first, second.cloud, guess);
  std::printf("%s: %.2f m along x\n", result.usable() ? "aligned" : result.reason,
              result.T_target_source.translation().x());
  return result.usable() ? 0 : 1;
}
