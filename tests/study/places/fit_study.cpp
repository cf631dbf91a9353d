#include "tests/study/places/fit_study.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <ostream>
#include <sstream>
#include <stdexcept>

#include "fusion/mapping/keyframe_submaps.hpp"
#include "fusion/places/localiser.hpp"

namespace infuse::study {
namespace {

constexpr double kMaxError = 1;  // m, of a right place

using Weights = Eigen::Vector2d;  // bias, of the product of inliers and agreement

/// What a search found.
struct Query {
  std::vector<places::PlaceFit> fits;
  int right = -1;  // index of the place that is right, or -1: none is
};

Weights features(const places::PlaceFit& fit) { return {1, fit.inliers * fit.agreement}; }

Result<std::vector<Query>> read_queries(const std::vector<std::string>& files) {
  std::vector<Query> out;
  for (const std::string& file : files) {
    std::ifstream in(file);
    if (!in) return fail("cannot be read", file);
    for (std::string line; std::getline(in, line);) {
      std::istringstream fields(line);
      Query query;
      places::PlaceFit fit;
      for (double error = 0; fields >> fit.inliers >> fit.agreement >> error;) {
        if (query.right < 0 && error < kMaxError) query.right = static_cast<int>(query.fits.size());
        query.fits.push_back(fit);
      }
      out.push_back(query);
    }
  }
  return out;
}

/// Weights that make the right places most likely (multinomial logistic regression against
/// nowhere, Newton's method), with a weak prior so that separable data have a result.
Weights fit_weights(const std::vector<Query>& queries) {
  constexpr double kPrior = 1e-3;
  Weights w = Weights::Zero();
  for (int step = 0; step < 100; ++step) {
    Weights gradient = -kPrior * w;
    Eigen::Matrix2d information = kPrior * Eigen::Matrix2d::Identity();
    for (const Query& query : queries) {
      std::vector<double> odds;
      double sum = 1;
      for (const auto& fit : query.fits) {
        odds.push_back(std::exp(std::clamp(w.dot(features(fit)), -30.0, 30.0)));
        sum += odds.back();
      }
      Weights mean = Weights::Zero();
      for (size_t i = 0; i < odds.size(); ++i) {
        const Weights x = features(query.fits[i]);
        mean += odds[i] / sum * x;
        information += odds[i] / sum * x * x.transpose();
        if (query.right == static_cast<int>(i)) gradient += x;
      }
      gradient -= mean;
      information -= mean * mean.transpose();
    }
    const Weights change = information.ldlt().solve(gradient);
    w += change * std::min(1.0, 5 / change.norm());
    if (change.norm() < 1e-9) break;
  }
  return w;
}

}  // namespace

std::string study_fits(std::ostream& out, const VisitOptions& options) {
  const auto map = open_true_map(options.map, options.map_drive);
  if (!map) return map.error().message();
  for (const std::string& drive : options.drives) {
    const auto visit = LidarVisit::open(drive);
    if (!visit) return visit.error().message();
    const places::LocaliserOptions localiser;
    places::PlaceMatcher matcher(map->map, visit->T_vehicle_lidar());
    mapping::KeyframeSubmaps submaps(localiser.keyframes, localiser.submaps,
                                     visit->T_vehicle_lidar());
    out << std::fixed << std::setprecision(4);
    const auto search = [&](const mapping::KeyframeSubmap& query) {
      const Eigen::Isometry3d& truth = visit->true_pose(query.keyframe.stamp);
      const auto found = matcher.search(query.submap);
      if (!found) throw std::runtime_error(found.error().message());
      for (const places::MatchedPlace& place : found->places) {
        out << place.fit.inliers << " " << place.fit.agreement << " "
            << map->error(place.T_map_vehicle, truth) << " ";
      }
      out << std::endl;
    };
    const std::string error = visit->play(
        [&](const auto& points, const auto& reflectivity, const mapping::SweepMotion& motion) {
          if (const auto query = submaps.add(points, reflectivity, motion)) search(*query);
        });
    if (!error.empty()) return error;
  }
  return "";
}

std::string study_place_odds(std::ostream& out, const std::vector<std::string>& files, bool fit) {
  const auto queries = read_queries(files);
  if (!queries) return queries.error().message();
  if (fit) {
    const Weights w = fit_weights(*queries);
    out << "log odds = " << w[0] << " + " << w[1] << " inliers agreement\n";
  }
  constexpr size_t kBins = 10;
  struct Bin {
    size_t count = 0, right = 0;
    double stated = 0;
  };
  std::array<Bin, kBins> bins{};
  const auto count = [&](double stated, bool right) {
    Bin& bin = bins[std::min(kBins - 1, static_cast<size_t>(stated * kBins))];
    ++bin.count;
    bin.right += right ? 1 : 0;
    bin.stated += stated;
  };
  size_t none = 0;
  for (const Query& query : *queries) {
    none += query.fits.empty() ? 1 : 0;
    if (query.fits.empty()) continue;
    count(places::place_probabilities(query.fits).best, query.right == 0);
  }
  out << queries->size() << " queries, of these " << none << " where no place fits\n"
      << "stated | queries | stated, mean | right\n";
  double error = 0, total = 0;
  for (size_t i = 0; i < kBins; ++i) {
    const Bin& bin = bins[i];
    if (bin.count == 0) continue;
    const auto n = static_cast<double>(bin.count);
    out << std::fixed << std::setprecision(3) << 0.1 * static_cast<double>(i) << " | " << bin.count
        << " | " << bin.stated / n << " | " << static_cast<double>(bin.right) / n << "\n";
    error += std::abs(bin.stated - static_cast<double>(bin.right));
    total += n;
  }
  out << "expected calibration error " << error / std::max(total, 1.0) << "\n";
  return "";
}

}  // namespace infuse::study
