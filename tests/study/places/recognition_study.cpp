#include "tests/study/places/recognition_study.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <map>
#include <numbers>
#include <stdexcept>

#include "fusion/features/air_returns.hpp"
#include "fusion/places/localiser.hpp"
#include "tests/study/places/bag_of_words.hpp"
#include "tests/study/places/precision_recall.hpp"
#include "tests/study/places/scan_context.hpp"
#include "tests/study/places/scan_words.hpp"
#include "tests/study/registration/k_means.hpp"

namespace infuse::study {
namespace {

const std::vector<int64_t> kMapRoute{115, 116, 117, 118, 119, 124, 107, 106, 105, 104};
const std::vector<int64_t> kQueryRoute{117, 118, 119, 124, 107, 106, 105, 104, 123, 112, 113, 114};
const std::vector<int64_t> kBuiltAlong{115, 116, 117, 118, 119, 124, 107, 106,
                                       105, 104, 123, 112, 113, 114, 125, 107};

constexpr std::array<const char*, 3> kBaselines{"bag of words", "Scan Context",
                                                "shape, as the localiser"};
constexpr size_t kVerified = kFeatureSets + kBaselines.size();

const char* method_name(size_t method) {
  if (method == kVerified) return "shape, verified by registration";
  return method < kFeatureSets ? name_of(static_cast<FeatureSet>(method))
                               : kBaselines[method - kFeatureSets];
}

/// What the methods need of a scan.
struct DescribedScan {
  Eigen::Isometry3d T_map_vehicle;
  ScanWords words;
  places::PlaceDescriptor shape;
  mapping::Submap cloud;
};

/// The turn without what the air returns.
mapping::Submap cloud_of(const Sweep& sweep) {
  features::AirReturns air;
  mapping::SubmapBuilder builder(places::LocaliserOptions().submaps);
  air.find(sweep);
  builder.add({air.without(sweep.x), sweep.y, sweep.z}, sweep.reflectivity,
              Eigen::Isometry3d::Identity());
  return builder.take();
}

DescribedScan describe(const SeasonScan& scan, const Rig& rig,
                       const registration::Codebook& codebook) {
  const Sweep& sweep = scan.scan.sweep;
  return {scan.T_map_vehicle, describe_scan(scan, rig, codebook),
          places::describe_place({sweep.x, sweep.y, sweep.z}, rig.lidars.front().T_vehicle_lidar),
          cloud_of(sweep)};
}

SeasonDrive render(const RecognitionOptions& options, uint64_t world, const Visit& visit,
                   const std::vector<int64_t>& route, double spacing) {
  auto drive = render_visit(options.map, world, visit, route, kBuiltAlong, spacing);
  if (!drive) throw std::runtime_error(drive.error().message());
  return *std::move(drive);
}

/// A codebook of another town, in two of the seasons.
registration::Codebook learn_words(const RecognitionOptions& options) {
  std::vector<Eigen::MatrixXf> all;
  Eigen::Index count = 0;
  for (const size_t visit : {0U, 2U}) {
    const SeasonDrive drive =
        render(options, options.learn_seed, season_visits()[visit], kQueryRoute, 90);
    for (const SeasonScan& scan : drive.scans) {
      all.push_back(sift_descriptors(scan, drive.rig));
      count += all.back().cols();
    }
  }
  constexpr Eigen::Index kMaxSamples = 12'000;
  const Eigen::Index stride = std::max<Eigen::Index>(1, count / kMaxSamples);
  Eigen::MatrixXf samples(128, (count + stride - 1) / stride);
  Eigen::Index at = 0, index = 0;
  for (const Eigen::MatrixXf& block : all) {
    for (Eigen::Index k = 0; k < block.cols(); ++k, ++index) {
      if (index % stride == 0) samples.col(at++) = block.col(k);
    }
  }
  return learn_codebook(samples.leftCols(at), options.words, 1, 12);
}

/// Where a query was seen from a place, and the information of both there.
struct Alignment {
  double x = 0, y = 0, yaw = 0;  // m, rad
  SetInformation information{};
};

/// The best of a grid about the place, at the heading of the shapes and its opposite: other lanes,
/// and places up to half their spacing away.
Alignment search_roughly(const MapScan& place, const ScanWords& query, double yaw) {
  constexpr size_t kAll = static_cast<size_t>(FeatureSet::kAll);
  Alignment best;
  best.information[kAll] = -1;
  for (const double turned : {0.0, std::numbers::pi}) {
    for (const double x : {-4.0, -2.0, 0.0, 2.0, 4.0}) {
      for (const double y : {-6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0}) {
        const SetInformation information = place.information(query, x, y, yaw + turned);
        if (information[kAll] > best.information[kAll]) best = {x, y, yaw + turned, information};
      }
    }
  }
  return best;
}

/// The best pose near a guess.
Alignment refine(const MapScan& place, const ScanWords& query, Alignment best) {
  constexpr size_t kAll = static_cast<size_t>(FeatureSet::kAll);
  for (const double scale : {0.5, 0.25}) {
    for (bool improved = true; improved;) {
      improved = false;
      const double step = 2 * scale, turn = 0.07 * scale;
      const std::array<std::array<double, 3>, 6> moves{
          {{step, 0, 0}, {-step, 0, 0}, {0, step, 0}, {0, -step, 0}, {0, 0, turn}, {0, 0, -turn}}};
      for (const auto& [dx, dy, turned] : moves) {
        const double x = best.x + dx, y = best.y + dy, yaw = best.yaw + turned;
        if (std::hypot(x, y) > 8) continue;
        const SetInformation other = place.information(query, x, y, yaw);
        if (other[kAll] <= best.information[kAll]) continue;
        best = {x, y, yaw, other};
        improved = true;
      }
    }
  }
  return best;
}

using Scores = std::vector<std::vector<double>>;  // by method, then by place

Scores score_query(const DescribedScan& query, const std::vector<MapScan>& map,
                   const std::vector<places::PlaceDescriptor>& shapes, const BagOfWords& bag,
                   size_t refined) {
  constexpr size_t kAll = static_cast<size_t>(FeatureSet::kAll);
  Scores out(kFeatureSets + kBaselines.size(), std::vector<double>(map.size(), -1));
  std::vector<std::pair<double, size_t>> order;
  std::vector<Alignment> rough(map.size());
  for (size_t k = 0; k < map.size(); ++k) {
    const places::PlaceSimilarity shape = places::compare_places(shapes[k], query.shape);
    out[kFeatureSets + 1][k] = scan_context_similarity(shapes[k], query.shape);
    out[kFeatureSets + 2][k] = shape.correlation;
    rough[k] = search_roughly(map[k], query.words, shape.yaw);
    order.emplace_back(-rough[k].information[kAll], k);
  }
  std::sort(order.begin(), order.end());
  for (size_t i = 0; i < std::min(refined, order.size()); ++i) {
    const size_t k = order[i].second;
    const SetInformation best = refine(map[k], query.words, rough[k]).information;
    for (size_t set = 0; set < kFeatureSets; ++set) out[set][k] = best[set];
  }
  std::vector<uint16_t> words;
  for (const auto& keypoint : query.words.keypoints) words.push_back(keypoint.word);
  const Eigen::VectorXd similarity = bag.similarities(words);
  out[kFeatureSets].assign(similarity.begin(), similarity.end());
  return out;
}

/// A map whose keyframes are scans.
class VerifiedMap {
 public:
  void add(const DescribedScan& scan, const Rig& rig) {
    map_.T_vehicle_lidar = rig.lidars.front().T_vehicle_lidar;
    map_.T_map_vehicle.push_back(scan.T_map_vehicle);
    map_.descriptors.push_back(scan.shape);
    clouds_.push_back(scan.cloud);
  }

  /// What the localiser's search answers to a scan; `nearest` is that of the true place.
  RankedAnswer answer(const DescribedScan& query, double nearest, double tolerance) {
    if (!matcher_) {
      map_.read_cloud = [this](size_t k) -> Result<mapping::Submap> { return clouds_[k]; };
      matcher_.emplace(map_, map_.T_vehicle_lidar);
    }
    RankedAnswer answer{-1e9, false, nearest <= tolerance};
    const auto found = matcher_->search(query.cloud);
    if (!found) throw std::runtime_error(found.error().message());
    if (found->places.empty()) return answer;
    answer.score = places::log_odds(found->places.front().fit);
    const Eigen::Vector3d error =
        found->places.front().T_map_vehicle.translation() - query.T_map_vehicle.translation();
    answer.right = error.head<2>().norm() <= tolerance;
    return answer;
  }

 private:
  places::PlaceMap map_;
  std::vector<mapping::Submap> clouds_;
  std::optional<places::PlaceMatcher> matcher_;
};

}  // namespace

void study_recognition(std::ostream& out, const RecognitionOptions& options) {
  const registration::Codebook codebook = learn_words(options);
  std::vector<MapScan> map;
  VerifiedMap verified;
  std::vector<places::PlaceDescriptor> shapes;
  std::vector<Eigen::Vector2d> where;
  std::vector<std::vector<uint16_t>> words;
  {
    const SeasonDrive drive =
        render(options, options.world_seed, season_visits()[0], kMapRoute, options.map_spacing);
    for (const SeasonScan& scan : drive.scans) {
      DescribedScan described = describe(scan, drive.rig, codebook);
      where.emplace_back(described.T_map_vehicle.translation().head<2>());
      shapes.push_back(described.shape);
      verified.add(described, drive.rig);
      auto& own = words.emplace_back();
      for (const auto& keypoint : described.words.keypoints) own.push_back(keypoint.word);
      map.emplace_back(std::move(described.words));
    }
  }
  const BagOfWords bag(words, options.words);
  out << "season | method | queries, on the map | area | recall at full precision | right, all "
         "accepted\n";
  std::map<size_t, std::vector<RankedAnswer>> of_all;
  for (size_t visit = 1; visit < season_visits().size(); ++visit) {
    const Visit& season = season_visits()[visit];
    const SeasonDrive drive =
        render(options, options.world_seed, season, kQueryRoute, options.query_spacing);
    std::map<size_t, std::vector<RankedAnswer>> answers;  // by method
    for (const SeasonScan& scan : drive.scans) {
      const DescribedScan query = describe(scan, drive.rig, codebook);
      const Eigen::Vector2d truth = query.T_map_vehicle.translation().head<2>();
      const auto distance = [&](size_t k) { return (where[k] - truth).norm(); };
      double nearest = 1e9;
      for (size_t k = 0; k < where.size(); ++k) nearest = std::min(nearest, distance(k));
      const RankedAnswer found = verified.answer(query, nearest, options.tolerance);
      answers[kVerified].push_back(found);
      if (visit > 1) of_all[kVerified].push_back(found);
      const Scores scores = score_query(query, map, shapes, bag, options.refined);
      for (size_t method = 0; method < scores.size(); ++method) {
        const auto best = std::max_element(scores[method].begin(), scores[method].end());
        const auto place = static_cast<size_t>(best - scores[method].begin());
        const RankedAnswer answer{*best, distance(place) <= options.tolerance,
                                  nearest <= options.tolerance};
        answers[method].push_back(answer);
        if (visit > 1) of_all[method].push_back(answer);  // the control is not one of the seasons
      }
    }
    const auto print = [&](const std::string& name, const auto& table) {
      for (const auto& [method, list] : table) {
        const PrecisionRecall curve = precision_recall(list);
        const auto on_map =
            std::count_if(list.begin(), list.end(), [](const RankedAnswer& a) { return a.on_map; });
        out << std::fixed << std::setprecision(3) << name << " | " << method_name(method) << " | "
            << list.size() << ", " << on_map << " | " << curve.area << " | " << curve.recall_at_full
            << " | " << curve.recall << std::endl;
      }
    };
    print(season.name, answers);
    if (visit + 1 == season_visits().size()) print("all", of_all);
  }
}

}  // namespace infuse::study
