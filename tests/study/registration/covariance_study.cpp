#include "tests/study/registration/covariance_study.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "drivers/measurement/angles.hpp"
#include "fixtures/simulator/world/random.hpp"
#include "fusion/registration/gicp.hpp"
#include "tests/study/registration/rendered_drive.hpp"

namespace infuse::study {

std::string NormalisedErrors::text() const {
  if (values.empty()) return "no usable result";
  std::vector<double> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  const auto count = static_cast<double>(values.size());
  const auto quantile = [&](double q) { return sorted[static_cast<size_t>(q * (count - 1))]; };
  const double mean = std::accumulate(sorted.begin(), sorted.end(), 0.0) / count;
  return fmt::format(
      "{} pairs: normalised squared error per direction {:.2f} (median {:.2f}, 90 % {:.2f}, "
      "maximum {:.1f}); {} with free directions, {} not usable\n"
      "  translation {:.2f} cm at a stated {:.2f} cm, rotation {:.4f} deg at a stated {:.4f} deg "
      "(root mean squares of pairs without free directions)",
      values.size(), mean, quantile(0.5), quantile(0.9), sorted.back(), with_free_directions,
      unusable, 100 * translation, 100 * stated_translation, rotation / kDegree,
      stated_rotation / kDegree);
}

NormalisedErrors normalised_errors(uint64_t first_seed, int drives) {
  NormalisedErrors errors;
  Eigen::Array4d squares = Eigen::Array4d::Zero();
  size_t whole = 0;
  for (int d = 0; d < drives; ++d) {
    const uint64_t seed = first_seed + static_cast<uint64_t>(d);
    const auto drive = render_drive(seed, {0, 0.5, 1.2, 2.2, 3.5}, {.images = false});
    if (!drive) throw std::runtime_error(drive.error().message());
    const simulator::Random random(seed, "guesses");
    uint64_t draw = 0;
    for (size_t t = 0; t < drive->scans.size(); ++t) {
      const Sweep& fixed = drive->scans[t].sweep;
      const auto target = registration::prepare_cloud({fixed.x, fixed.y, fixed.z});
      for (size_t s = t + 1; s < drive->scans.size(); ++s) {
        const Sweep& moved = drive->scans[s].sweep;
        const auto source = registration::prepare_cloud({moved.x, moved.y, moved.z});
        const Eigen::Isometry3d truth =
            drive->scans[t].T_world_lidar.inverse() * drive->scans[s].T_world_lidar;
        geometry::Vector6 off;
        for (int i = 0; i < 6; ++i) {
          off[i] = random.uniform(draw++, -1, 1) * (i < 3 ? kDegree : 0.2);
        }
        const auto result = registration::gicp(target, source.cloud, geometry::exp(off) * truth);
        if (!result.usable()) {
          ++errors.unusable;
          continue;
        }
        const geometry::Vector6 error = geometry::log(truth * result.T_target_source.inverse());
        errors.values.push_back(error.dot(result.information * error) /
                                (6 - result.free_directions));
        if (result.free_directions > 0) {
          ++errors.with_free_directions;
          continue;
        }
        ++whole;
        squares += Eigen::Array4d(
            error.tail<3>().squaredNorm(), result.covariance.bottomRightCorner<3, 3>().trace(),
            error.head<3>().squaredNorm(), result.covariance.topLeftCorner<3, 3>().trace());
      }
    }
  }
  squares = (squares / static_cast<double>(std::max<size_t>(whole, 1))).sqrt().eval();
  errors.translation = squares[0];
  errors.stated_translation = squares[1];
  errors.rotation = squares[2];
  errors.stated_rotation = squares[3];
  return errors;
}

}  // namespace infuse::study
