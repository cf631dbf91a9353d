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
#include "fusion/places/visual/sequence_information.hpp"
#include "tests/study/places/precision_recall.hpp"
#include "tests/study/places/season_drive.hpp"
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

/// The answers of matches.
std::vector<RankedAnswer> ranked(const std::vector<places::SequenceMatch>& matches, bool by_margin,
                                 const ImageVisit& visit, const ImageVisit& map, double tolerance) {
  std::vector<RankedAnswer> out;
  for (size_t i = 0; i < matches.size(); ++i) {
    out.push_back({by_margin ? matches[i].margin : matches[i].score,
                   is_right(map, matches[i].place, visit.where[i], tolerance),
                   is_on_map(map, visit.where[i], tolerance)});
  }
  return out;
}

/// The images of all visits of a town.
std::vector<places::ImageDescriptor> all_images(const std::vector<ImageVisit>& town) {
  std::vector<places::ImageDescriptor> out;
  for (const ImageVisit& visit : town) {
    out.insert(out.end(), visit.images.begin(), visit.images.end());
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
  const registration::Codebook codebook =
      places::learn_cell_words(all_images(render_town(options, options.learnt)), 8);
  out << "season | method | queries, on the map | area | recall at full precision | right, all "
         "accepted | found, wrong\n";
  const auto town = render_town(options, options.tested);
  const places::CellWords map_words = places::cell_words(town[0].images, codebook);
  for (size_t k = 1; k < town.size(); ++k) {
    const char* season = season_visits()[k].name;
    const places::SimilarityTable table = compare(town[k], town[0]);
    for (const size_t length : {1U, 9U, 21U}) {
      const places::SequenceMatchOptions matching{.length = length};
      const auto matches = places::match_sequences(table, matching);
      const auto chances = places::MatchEvidence(table, matching).chances(matches);
      const auto answers = ranked(matches, true, town[k], town[0], options.tolerance);
      int found = 0, wrong = 0;
      for (size_t i = 0; i < matches.size(); ++i) {
        if (chances[i] > 0.02) continue;
        ++found;
        wrong += answers[i].right ? 0 : 1;
      }
      print_answers(out, season, "similarity of " + std::to_string(length), answers);
      out << found << ", " << wrong << std::endl;
    }
    const places::CellWords words = places::cell_words(town[k].images, codebook);
    for (const int memory : {0, 1}) {
      const auto matches = places::match_by_information(words, map_words, {.memory = memory});
      print_answers(out, season,
                    memory == 0 ? "mutual information of 21" : "directed information of 21",
                    ranked(matches, false, town[k], town[0], options.tolerance));
      out << "-" << std::endl;
    }
  }
}

}  // namespace infuse::study
