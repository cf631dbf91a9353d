#include "tests/study/places/image_study.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <stdexcept>

#include "fusion/places/image_descriptor.hpp"
#include "fusion/places/match_evidence.hpp"
#include "fusion/places/small_image.hpp"
#include "tests/study/dependence/directed_information.hpp"
#include "tests/study/places/precision_recall.hpp"
#include "tests/study/places/season_drive.hpp"
#include "tests/study/registration/k_means.hpp"
#include "tests/study/registration/rendered_drive.hpp"

namespace infuse::study {
namespace {

const std::vector<int64_t> kStreetMapRoute{115, 116, 117, 118, 119, 124, 107, 106, 105, 104};
const std::vector<int64_t> kStreetQueryRoute{117, 118, 119, 124, 107, 106,
                                             105, 104, 123, 112, 113, 114};
const std::vector<int64_t> kStreetsBuilt{115, 116, 117, 118, 119, 124, 107, 106,
                                         105, 104, 123, 112, 113, 114, 125, 107};

/// Images of a visit, described, with the places where they were taken.
struct ImageVisit {
  std::vector<places::ImageDescriptor> images;
  std::vector<Eigen::Vector2d> where;
};

ImageVisit render_images(const ImageStudyOptions& options, uint64_t world, const Visit& visit,
                         const std::vector<int64_t>& route) {
  simulator::Scenario s;
  s.seed = visit.seed + world;
  s.world_seed = world;
  s.map = options.map;
  s.route = route;
  s.built_along = kStreetsBuilt;
  s.street.build_radius = 80;
  s.street.season = visit.season;
  s.street.parked_cars = visit.parked_cars;
  s.air = visit.air;
  s.light = visit.light;
  s.motion.speed = s.motion.start_speed = 8;
  s.duration = 200;
  s.lidars.emplace_back();
  simulator::ScenarioCamera camera;
  camera.options.grey = true;
  camera.options.samples = 1;
  camera.options.intrinsics = {
      .width = 96, .height = 48, .fx = 68, .fy = 68, .cx = 47.5, .cy = 23.5};
  Eigen::Matrix3d forward;  // camera axes of a camera that faces along x
  forward << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  camera.options.T_vehicle_camera.linear() = forward;
  camera.options.T_vehicle_camera.translation() = Eigen::Vector3d(1.5, 0, 1.5);
  s.cameras.push_back(camera);
  auto simulation = simulator::Simulation::create(s);
  if (!simulation) throw std::runtime_error(simulation.error().message());
  ImageVisit out;
  const double end = simulation->motion().distance_driven(simulation->duration()) - 5;
  for (double way = 5; way < end; way += options.spacing) {
    const double time = time_of(*simulation, way);
    const CameraFrame frame = simulation->render_image(0, time, out.images.size());
    out.images.push_back(places::describe_image(places::shrink_image(frame, 64, 32), 64, 32));
    out.where.emplace_back(simulation->pose()(time).translation().head<2>());
  }
  places::remove_common_view(out.images);
  return out;
}

/// A town: the map's visit and the others.
std::vector<ImageVisit> render_town(const ImageStudyOptions& options, uint64_t world) {
  std::vector<ImageVisit> out;
  for (size_t k = 0; k < season_visits().size(); ++k) {
    out.push_back(render_images(options, world, season_visits()[k],
                                k == 0 ? kStreetMapRoute : kStreetQueryRoute));
  }
  return out;
}

places::SimilarityTable compare(const ImageVisit& queries, const ImageVisit& map) {
  places::SimilarityTable table{queries.images.size(), map.images.size(), {}};
  for (const auto& query : queries.images) {
    for (const auto& place : map.images)
      table.values.push_back(static_cast<float>(places::similarity(query, place)));
  }
  return table;
}

bool is_right(const ImageVisit& map, size_t place, const Eigen::Vector2d& truth, double tolerance) {
  return (map.where[place] - truth).norm() <= tolerance;
}

bool is_on_map(const ImageVisit& map, const Eigen::Vector2d& truth, double tolerance) {
  return std::any_of(map.where.begin(), map.where.end(), [&](const Eigen::Vector2d& place) {
    return (place - truth).norm() <= tolerance;
  });
}

/// Features of the cells of images, one per column: of each image, cell by cell.
Eigen::MatrixXf cell_features(const ImageVisit& visit) {
  const places::ImageDescriptor& first = visit.images.front();
  const Eigen::Index rows = first.orientations;
  const Eigen::Index cells = static_cast<Eigen::Index>(first.values.size()) / rows;
  Eigen::MatrixXf features(rows, cells * static_cast<Eigen::Index>(visit.images.size()));
  for (size_t k = 0; k < visit.images.size(); ++k) {
    features.middleCols(static_cast<Eigen::Index>(k) * cells, cells) =
        Eigen::Map<const Eigen::MatrixXf>(visit.images[k].values.data(), rows, cells);
  }
  return features;
}

/// Codewords of the cells of each image.
using ImageWords = std::vector<std::vector<int32_t>>;

ImageWords words_of(const ImageVisit& visit, const registration::Codebook& codebook) {
  const auto words = registration::quantise(codebook, cell_features(visit));
  const size_t cells = words.size() / visit.images.size();
  ImageWords out(visit.images.size());
  for (size_t k = 0; k < words.size(); ++k)
    out[k / cells].push_back(static_cast<int32_t>(words[k]));
  return out;
}

registration::Codebook learn_image_words(const std::vector<ImageVisit>& town) {
  constexpr size_t kWords = 8;
  constexpr Eigen::Index kStride = 8;
  std::vector<Eigen::MatrixXf> all;
  Eigen::Index count = 0;
  for (const ImageVisit& visit : town) {
    all.push_back(cell_features(visit));
    count += all.back().cols();
  }
  Eigen::MatrixXf features(all.front().rows(), count);
  count = 0;
  for (const Eigen::MatrixXf& block : all) {
    features.middleCols(count, block.cols()) = block;
    count += block.cols();
  }
  const Eigen::MatrixXf samples = features(Eigen::all, Eigen::seq(0, count - 1, kStride));
  return learn_codebook(samples, kWords, 1);
}

/// The sequence of every cell over images `begin` … `begin + count` − 1, one after the other.
std::vector<int32_t> cell_sequences(const ImageWords& words, size_t begin, size_t count) {
  std::vector<int32_t> out;
  out.reserve(count * words.front().size());
  for (size_t cell = 0; cell < words.front().size(); ++cell) {
    for (size_t k = begin; k < begin + count; ++k) out.push_back(words[k][cell]);
  }
  return out;
}

/// Answers by the dependence of sequences of codewords; memory 0 is mutual information. The places
/// of the map follow each other as the images of the query do.
std::vector<RankedAnswer> match_words(const ImageWords& queries, const ImageWords& places,
                                      const ImageVisit& visit, const ImageVisit& map, size_t length,
                                      int memory, double tolerance) {
  const size_t used = std::min({length, queries.size(), places.size()});
  std::vector<std::vector<int32_t>> of_map;
  for (size_t j = 0; j + used <= places.size(); ++j)
    of_map.push_back(cell_sequences(places, j, used));
  std::vector<RankedAnswer> out;
  for (size_t i = 0; i < queries.size(); ++i) {
    const size_t before = std::min(i, used / 2);
    const size_t begin = std::min(i - before, queries.size() - used);
    const std::vector<int32_t> x = cell_sequences(queries, begin, used);
    double best = -1;
    size_t place = 0;
    for (size_t j = 0; j < of_map.size(); ++j) {
      const auto information = directed_information_rate(x, of_map[j], memory,
                                                         CountEntropyOptions::Estimator::kChaoShen);
      if (!information.usable() || information.value <= best) continue;
      best = information.value;
      place = j + i - begin;
    }
    const Eigen::Vector2d& truth = visit.where[i];
    out.push_back({best, is_right(map, place, truth, tolerance), is_on_map(map, truth, tolerance)});
  }
  return out;
}

void print_answers(std::ostream& out, const char* season, const std::string& method,
                   const std::vector<RankedAnswer>& answers) {
  const PrecisionRecall curve = precision_recall(answers);
  const auto on_map =
      std::count_if(answers.begin(), answers.end(), [](const RankedAnswer& a) { return a.on_map; });
  out << std::fixed << std::setprecision(3) << season << " | " << method << " | " << answers.size()
      << ", " << on_map << " | " << curve.area << " | " << curve.recall_at_full << " | "
      << curve.recall << " | ";
}

}  // namespace

void study_images(std::ostream& out, const ImageStudyOptions& options) {
  // The codebook is of a town that is not tested.
  const registration::Codebook codebook = learn_image_words(render_town(options, options.learnt));
  out << "season | method | queries, on the map | area | recall at full precision | right, all "
         "accepted | found, wrong\n";
  const auto town = render_town(options, options.tested);
  const auto map_words = words_of(town[0], codebook);
  for (size_t k = 1; k < town.size(); ++k) {
    const char* season = season_visits()[k].name;
    const places::SimilarityTable table = compare(town[k], town[0]);
    for (const size_t length : {1U, 9U, 21U}) {
      const places::SequenceMatchOptions matching{.length = length};
      const places::MatchEvidence evidence(table, matching);
      const auto matches = places::match_sequences(table, matching);
      std::vector<RankedAnswer> answers;
      int found = 0, wrong = 0;
      for (size_t i = 0; i < matches.size(); ++i) {
        const Eigen::Vector2d& truth = town[k].where[i];
        answers.push_back({matches[i].margin,
                           is_right(town[0], matches[i].place, truth, options.tolerance),
                           is_on_map(town[0], truth, options.tolerance)});
        if (evidence.chance(matches[i]) > 0.02) continue;
        ++found;
        wrong += answers.back().right ? 0 : 1;
      }
      print_answers(out, season, "similarity of " + std::to_string(length), answers);
      out << found << ", " << wrong << std::endl;
    }
    const auto words = words_of(town[k], codebook);
    for (const int memory : {0, 1}) {
      print_answers(out, season,
                    memory == 0 ? "mutual information of 21" : "directed information of 21",
                    match_words(words, map_words, town[k], town[0], 21, memory, options.tolerance));
      out << "-" << std::endl;
    }
  }
}

}  // namespace infuse::study
