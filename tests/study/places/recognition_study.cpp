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
#include "fusion/places/visual/bag_of_words.hpp"
#include "fusion/places/visual/scan_words.hpp"
#include "fusion/registration/visual/k_means.hpp"
#include "tests/study/places/keypoint_words.hpp"
#include "tests/study/places/precision_recall.hpp"
#include "tests/study/places/scan_context.hpp"

namespace infuse::study {
namespace {

const std::vector<int64_t> kMapRoute{115, 116, 117, 118, 119, 124, 107, 106, 105, 104};
const std::vector<int64_t> kQueryRoute{117, 118, 119, 124, 107, 106, 105, 104, 123, 112, 113, 114};
const std::vector<int64_t> kBuiltAlong{115, 116, 117, 118, 119, 124, 107, 106,
                                       105, 104, 123, 112, 113, 114, 125, 107};

constexpr std::array<const char*, 3> kBaselines{"bag of words of the images", "Scan Context",
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
  places::ScanWords words;
  std::vector<Keypoint> keypoints;
  places::ImageKeypoints images;  // of all cameras
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

/// The keypoints of all images: another camera sees a place from the other direction.
places::ImageKeypoints keypoints_of(const std::vector<CameraFrame>& images) {
  places::ImageKeypoints out{Eigen::MatrixXf(128, 0), {}};
  for (const CameraFrame& image : images) {
    const places::ImageKeypoints found = places::sift_keypoints(image);
    const Eigen::Index before = out.descriptors.cols();
    out.descriptors.conservativeResize(128, before + found.descriptors.cols());
    out.descriptors.rightCols(found.descriptors.cols()) = found.descriptors;
    out.parts.insert(out.parts.end(), found.parts.begin(), found.parts.end());
  }
  return out;
}

DescribedScan describe(const SeasonScan& scan, const Rig& rig,
                       const registration::Codebook& codebook) {
  const Sweep& sweep = scan.scan.sweep;
  const Eigen::Isometry3d& T_vehicle_lidar = rig.lidars.front().T_vehicle_lidar;
  const auto images = images_of(scan.scan, rig.cameras);
  return {scan.T_map_vehicle,
          places::describe_scan({features::make_sweep_view(sweep), images}, T_vehicle_lidar),
          find_keypoints(scan, rig, codebook),
          keypoints_of(scan.scan.images),
          places::describe_place({sweep.x, sweep.y, sweep.z}, T_vehicle_lidar),
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
  return registration::learn_codebook(samples.leftCols(at), options.words, 1, 12);
}

/// Bags of words of images, as `infuse places --method words`.
class ImageBags {
 public:
  explicit ImageBags(const std::vector<places::ImageKeypoints>& map)
      : codebook_(places::learn_sift_words(map)),
        bags_(words(map), places::number_of_words(codebook_)) {}

  Eigen::VectorXd similarities(const places::ImageKeypoints& query) const {
    return bags_.similarities(places::placed_words(codebook_, query));
  }

 private:
  std::vector<std::vector<uint32_t>> words(const std::vector<places::ImageKeypoints>& map) const {
    std::vector<std::vector<uint32_t>> out;
    for (const places::ImageKeypoints& place : map)
      out.push_back(places::placed_words(codebook_, place));
    return out;
  }

  registration::Codebook codebook_;
  places::BagOfWords bags_;
};

using Scores = std::vector<std::vector<double>>;  // by method, then by place

/// A place of the map, by each method.
struct MapPlace {
  places::MapScan scan;
  MapKeypoints keypoints;
  places::PlaceDescriptor shape;
};

Scores score_query(const DescribedScan& query, const std::vector<MapPlace>& map,
                   const ImageBags& bags, size_t refined) {
  constexpr bool kGrey = true;
  Scores out(kFeatureSets + kBaselines.size(), std::vector<double>(map.size(), -1));
  std::vector<std::pair<double, size_t>> order;
  std::vector<places::InformationAlignment> rough(map.size());
  for (size_t k = 0; k < map.size(); ++k) {
    const places::PlaceSimilarity shape = places::compare_places(map[k].shape, query.shape);
    out[kFeatureSets + 1][k] = scan_context_similarity(map[k].shape, query.shape);
    out[kFeatureSets + 2][k] = shape.correlation;
    rough[k] = places::search_by_information(map[k].scan, query.words, shape.yaw, kGrey);
    order.emplace_back(-rough[k].information.total(kGrey), k);
  }
  std::sort(order.begin(), order.end());
  for (size_t i = 0; i < std::min(refined, order.size()); ++i) {
    const MapPlace& place = map[order[i].second];
    const auto best =
        places::refine_by_information(place.scan, query.words, rough[order[i].second], kGrey);
    const auto information = information_of_sets(
        best.information, place.keypoints.information(query.keypoints, best.x, best.y, best.yaw));
    for (size_t set = 0; set < kFeatureSets; ++set) out[set][order[i].second] = information[set];
  }
  const Eigen::VectorXd similarity = bags.similarities(query.images);
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
  std::vector<MapPlace> map;
  VerifiedMap verified;
  std::vector<Eigen::Vector2d> where;
  std::vector<places::ImageKeypoints> images;
  {
    const SeasonDrive drive =
        render(options, options.world_seed, season_visits()[0], kMapRoute, options.map_spacing);
    for (const SeasonScan& scan : drive.scans) {
      DescribedScan described = describe(scan, drive.rig, codebook);
      where.emplace_back(described.T_map_vehicle.translation().head<2>());
      verified.add(described, drive.rig);
      images.push_back(std::move(described.images));
      map.push_back({places::MapScan(std::move(described.words)),
                     MapKeypoints(std::move(described.keypoints)), described.shape});
    }
  }
  const ImageBags bags(images);
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
      const Scores scores = score_query(query, map, bags, options.refined);
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
