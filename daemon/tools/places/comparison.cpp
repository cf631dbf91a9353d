#include "daemon/tools/places/comparison.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <optional>

#include "daemon/command_line/progress_line.hpp"
#include "daemon/tools/places/image_files.hpp"
#include "daemon/tools/places/lidar_places.hpp"
#include "drivers/recording/drive_toml.hpp"
#include "fusion/places/image_descriptor.hpp"
#include "fusion/places/match_evidence.hpp"
#include "fusion/places/small_image.hpp"
#include "fusion/places/visual/bag_of_words.hpp"
#include "fusion/places/visual/sequence_information.hpp"

namespace infuse::daemon {
namespace {

using places::SimilarityTable;

constexpr size_t kMaxSimilarities = 400'000'000;  // 1.6 GB
constexpr int kDescribedWidth = 64;               // pixels
constexpr size_t kCellWords = 8;                  // P 6.2.3 leaves the number open
constexpr int kMaxSiftWidth = 640;                // pixels
constexpr size_t kAligned = 10;  // places of a query that are aligned by information

Result<void> check_size(const Comparison& comparison, const ComparisonRequest& request) {
  if (comparison.places.names.size() <= kMaxSimilarities / comparison.queries.names.size())
    return {};
  return fail("too many pairs of places", request.queries, "at most 400 million");
}

/// Fills a table with `similarity_of(query, place)`.
template <class SimilarityOf>
SimilarityTable fill_table(const Comparison& comparison, SimilarityOf similarity_of) {
  SimilarityTable table{comparison.queries.names.size(), comparison.places.names.size(), {}};
  table.values.reserve(table.queries * table.places);
  for (size_t i = 0; i < table.queries; ++i) {
    for (size_t j = 0; j < table.places; ++j)
      table.values.push_back(static_cast<float>(similarity_of(i, j)));
  }
  return table;
}

// --- images ---

/// Reads both drives; `on_place` and `on_query` receive the images.
template <class OnPlace, class OnQuery>
Result<Comparison> read_images(const ComparisonRequest& request, OnPlace on_place,
                               OnQuery on_query) {
  auto places = read_image_files(request.places, request.camera, std::nullopt, on_place);
  if (!places) return tl::unexpected(places.error());
  auto queries = read_image_files(request.queries, request.camera, places->aspect, on_query);
  if (!queries) return tl::unexpected(queries.error());
  Comparison out{std::move(places->list), std::move(queries->list), {}};
  if (auto checked = check_size(out, request); !checked) return tl::unexpected(checked.error());
  return out;
}

/// The images of both drives, described alike.
struct DescribedImages {
  Comparison comparison;
  std::vector<places::ImageDescriptor> places, queries;
};

Result<DescribedImages> describe_images(const ComparisonRequest& request) {
  DescribedImages out;
  const auto adder = [&](std::vector<places::ImageDescriptor>& list) {
    return [&](const CameraFrame& frame) {
      const int height =
          std::max(8, (kDescribedWidth * frame.height + frame.width / 2) / frame.width);
      const auto pixels = places::shrink_image(frame, kDescribedWidth, height);
      list.push_back(request.method == "correlation"
                         ? places::describe_contrast(pixels, kDescribedWidth, height)
                         : places::describe_image(pixels, kDescribedWidth, height));
    };
  };
  auto read = read_images(request, adder(out.places), adder(out.queries));
  if (!read) return tl::unexpected(read.error());
  out.comparison = std::move(*read);
  places::remove_common_view(out.places);
  places::remove_common_view(out.queries);
  return out;
}

/// The keypoints of an image, reduced if it is large.
places::ImageKeypoints keypoints_of(const CameraFrame& frame) {
  if (frame.width <= kMaxSiftWidth) return places::sift_keypoints(frame);
  CameraFrame small;
  small.width = kMaxSiftWidth;
  small.height = std::max(1, kMaxSiftWidth * frame.height / frame.width);
  small.format = PixelFormat::kGrey8;
  small.pixels = places::shrink_image(frame, small.width, small.height);
  return places::sift_keypoints(small);
}

/// Bags of words, learned of the places themselves: as the first query is read all places are, and
/// their descriptors, a quarter of a megabyte an image, become words.
Result<Comparison> compare_words(const ComparisonRequest& request, SimilarityTable& table) {
  std::vector<places::ImageKeypoints> places;
  std::optional<registration::Codebook> codebook;
  std::vector<std::vector<uint32_t>> words, queries;
  const auto learn = [&] {
    codebook = places::learn_sift_words(places);
    for (const places::ImageKeypoints& image : places)
      words.push_back(places::placed_words(*codebook, image));
    places = {};
  };
  auto out = read_images(
      request, [&](const CameraFrame& frame) { places.push_back(keypoints_of(frame)); },
      [&](const CameraFrame& frame) {
        if (!codebook) learn();
        queries.push_back(places::placed_words(*codebook, keypoints_of(frame)));
      });
  if (!out) return out;
  if (!codebook || codebook->size() == 0)
    return fail("the images have no keypoints", request.places, "try --method edges");
  const places::BagOfWords bag(words, places::number_of_words(*codebook));
  std::vector<Eigen::VectorXd> similarities;
  for (const std::vector<uint32_t>& query : queries)
    similarities.push_back(bag.similarities(query));
  table = fill_table(*out, [&](size_t query, size_t place) {
    return similarities[query][static_cast<Eigen::Index>(place)];
  });
  return out;
}

// --- sweeps ---

/// Total mutual information of the places that look most alike, 0 of the others (P 5.3).
SimilarityTable compare_information(const Comparison& comparison, const LidarPlaces& places,
                                    const LidarPlaces& queries, bool grey) {
  SimilarityTable table = fill_table(comparison, [](size_t, size_t) { return 0; });
  ProgressLine line;
  for (size_t i = 0; i < table.queries; ++i) {
    std::vector<std::pair<places::PlaceSimilarity, size_t>> alike;
    for (size_t j = 0; j < table.places; ++j)
      alike.emplace_back(places::compare_places(places.shapes[j], queries.shapes[i]), j);
    const size_t aligned = std::min(kAligned, alike.size());
    std::partial_sort(
        alike.begin(), alike.begin() + static_cast<std::ptrdiff_t>(aligned), alike.end(),
        [](const auto& a, const auto& b) { return a.first.correlation > b.first.correlation; });
    for (size_t k = 0; k < aligned; ++k) {
      const auto& [shape, j] = alike[k];
      const places::MapScan place(places.words[j]);  // a third of a megabyte: not kept of all
      const auto rough = places::search_by_information(place, queries.words[i], shape.yaw, grey);
      const auto best = places::refine_by_information(place, queries.words[i], rough, grey);
      table.at(i, j) = static_cast<float>(best.information.total(grey));
    }
    line.show(static_cast<double>(i + 1) / static_cast<double>(table.queries), "information");
  }
  line.clear();
  return table;
}

/// True if the drive has a camera.
bool has_camera(const std::string& path) {
  const auto drive = recording::Drive::open(path);
  return drive && !drive->description.rig.cameras.empty();
}

Result<Comparison> compare_sweeps(const ComparisonRequest& request, SimilarityTable& table) {
  const bool information = request.method == "total-mi";
  const LidarPlacesRequest reading{
      .lidar = request.lidar,
      .every = request.every,
      .words = information,
      .grey = information && has_camera(request.places) && has_camera(request.queries)};
  auto places = read_lidar_places(request.places, reading);
  if (!places) return tl::unexpected(places.error());
  auto queries = read_lidar_places(request.queries, reading);
  if (!queries) return tl::unexpected(queries.error());
  Comparison out{places->list, queries->list, {}};
  if (auto checked = check_size(out, request); !checked) return tl::unexpected(checked.error());
  table = information
              ? compare_information(out, *places, *queries, reading.grey)
              : fill_table(out, [&](size_t query, size_t place) {
                  return places::compare_places(places->shapes[place], queries->shapes[query])
                      .correlation;
                });
  return out;
}

// --- sequences ---

/// Adds the answers of `matches`, with how probable they are by chance.
void answer(const std::vector<places::SequenceMatch>& matches,
            const places::MatchEvidence& evidence, Comparison& out) {
  const std::vector<double> chances = evidence.chances(matches);
  for (size_t k = 0; k < matches.size(); ++k) out.answers.push_back({matches[k], chances[k]});
}

void match_table(const SimilarityTable& table, const ComparisonRequest& request, Comparison& out) {
  if (request.sequence == "none") {
    for (const auto& match : places::match_sequences(table, {.length = 1}))
      out.answers.push_back({match, std::nullopt});  // in reverse order they are the same
    return;
  }
  const places::SequenceMatchOptions options{.length = request.length};
  answer(places::match_sequences(table, options), places::MatchEvidence(table, options), out);
}

Comparison match_information(const ComparisonRequest& request, DescribedImages images) {
  const registration::Codebook codebook = places::learn_cell_words(images.places, kCellWords);
  const places::CellWords places = places::cell_words(images.places, codebook);
  const places::CellWords queries = places::cell_words(images.queries, codebook);
  const places::SequenceInformationOptions options{.length = request.length,
                                                   .memory = request.sequence == "mutual" ? 0 : 1};
  const places::CellWords reversed(queries.rbegin(), queries.rend());
  answer(places::match_by_information(queries, places, options),
         {places::match_by_information(reversed, places, options), options.length},
         images.comparison);
  return std::move(images.comparison);
}

}  // namespace

const std::vector<std::string>& comparison_methods() {
  static const std::vector<std::string> kMethods{"edges", "correlation", "words", "shape",
                                                 "total-mi"};
  return kMethods;
}

const std::vector<std::string>& sequence_methods() {
  static const std::vector<std::string> kMethods{"none", "match", "mutual", "directed"};
  return kMethods;
}

Result<Comparison> compare_drives(const ComparisonRequest& request) {
  const bool information = request.sequence == "mutual" || request.sequence == "directed";
  if (information && request.method != "edges") {
    return fail("--sequence " + request.sequence + " compares codewords of edges", "",
                "leave --method " + request.method + " out");
  }
  SimilarityTable table;
  Result<Comparison> out;
  if (request.method == "shape" || request.method == "total-mi") {
    out = compare_sweeps(request, table);
  } else if (request.method == "words") {
    out = compare_words(request, table);
  } else {
    auto images = describe_images(request);
    if (!images) return tl::unexpected(images.error());
    if (information) return match_information(request, std::move(*images));
    table = fill_table(images->comparison, [&](size_t query, size_t place) {
      return places::similarity(images->queries[query], images->places[place]);
    });
    out = std::move(images->comparison);
  }
  if (out) match_table(table, request, *out);
  return out;
}

}  // namespace infuse::daemon
