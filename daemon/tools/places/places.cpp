#include "daemon/tools/places/places.hpp"

#include <spdlog/fmt/fmt.h>

#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/protocol/json.hpp"
#include "daemon/tools/places/image_drive.hpp"
#include "drivers/text/text_file.hpp"
#include "fusion/places/match_evidence.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kPlacesProgram = "infuse places";
constexpr size_t kMaxSimilarities = 400'000'000;  // 1.6 GB

struct PlacesArguments {
  std::string places, queries, camera, output;
  size_t length = 21;
  double max_chance = 0.02;
  bool json = false;
};

/// The answer to one query.
struct ImageAnswer {
  places::SequenceMatch match;
  double chance = 1;  ///< probability that the match is one by chance
};

std::vector<ImageAnswer> match_images(const ImageDrive& places, const ImageDrive& queries,
                                      size_t length) {
  places::SimilarityTable table{queries.descriptors.size(), places.descriptors.size(), {}};
  table.values.reserve(table.queries * table.places);
  for (const auto& query : queries.descriptors) {
    for (const auto& place : places.descriptors) {
      table.values.push_back(static_cast<float>(places::similarity(query, place)));
    }
  }
  const places::SequenceMatchOptions options{.length = length};
  const places::MatchEvidence evidence(table, options);
  std::vector<ImageAnswer> out;
  for (const auto& match : places::match_sequences(table, options)) {
    out.push_back({match, evidence.chance(match)});
  }
  return out;
}

Json answers_json(const ImageDrive& places, const ImageDrive& queries,
                  const std::vector<ImageAnswer>& answers, double max_chance) {
  Json out = Json::array();
  for (size_t i = 0; i < answers.size(); ++i) {
    const ImageAnswer& a = answers[i];
    Json row = {{"query", queries.names[i]}};
    if (!queries.stamps.empty()) row["stamp"] = queries.stamps[i].ns();
    row["place"] = places.names[a.match.place];
    row["index"] = a.match.place;
    if (!places.stamps.empty()) row["place_stamp"] = places.stamps[a.match.place].ns();
    row["found"] = a.chance <= max_chance;
    row["chance"] = a.chance;
    row["score"] = a.match.score;
    row["margin"] = a.match.margin;
    if (a.match.runner_up != a.match.place) row["runner_up"] = places.names[a.match.runner_up];
    out.push_back(std::move(row));
  }
  return out;
}

std::string answers_csv(const ImageDrive& places, const ImageDrive& queries,
                        const std::vector<ImageAnswer>& answers) {
  std::string out = "query,place,chance,score,margin,runner_up\n";
  for (size_t i = 0; i < answers.size(); ++i) {
    const ImageAnswer& a = answers[i];
    out += fmt::format("{},{},{:.4f},{:.3f},{:.3f},{}\n", queries.names[i],
                       places.names[a.match.place], a.chance, a.match.score, a.match.margin,
                       places.names[a.match.runner_up]);
  }
  return out;
}

int run_places(const PlacesArguments& arguments) {
  const auto places = read_image_drive(arguments.places, arguments.camera);
  if (!places) return print_error(kPlacesProgram, places.error(), kUnreadable);
  const auto queries = read_image_drive(arguments.queries, arguments.camera, places->aspect);
  if (!queries) return print_error(kPlacesProgram, queries.error(), kUnreadable);
  if (places->names.size() > kMaxSimilarities / queries->names.size()) {
    return print_error(kPlacesProgram,
                       {"too many pairs of images", arguments.queries,
                        fmt::format("at most {} million", kMaxSimilarities / 1'000'000)},
                       kUnreadable);
  }
  const auto answers = match_images(*places, *queries, arguments.length);
  size_t found = 0;
  for (const ImageAnswer& a : answers) found += a.chance <= arguments.max_chance ? 1 : 0;
  if (!arguments.output.empty()) {
    const auto written =
        text::write_text(arguments.output, answers_csv(*places, *queries, answers));
    if (!written) return print_error(kPlacesProgram, written.error(), kFailure);
  }
  if (arguments.json) {
    std::cout << json_text(
                     {{"queries", queries->names.size()},
                      {"places", places->names.size()},
                      {"length", arguments.length},
                      {"found", found},
                      {"answers", answers_json(*places, *queries, answers, arguments.max_chance)}})
              << "\n";
  } else {
    std::cout << fmt::format("{} images sought among {} places by sequences of {}: {} found\n",
                             queries->names.size(), places->names.size(), arguments.length, found);
    if (queries->names.size() < 2 * arguments.length)
      std::cout << "too few images to exclude chance: twice --length are needed\n";
  }
  return found > 0 ? kDone : kFailure;
}

}  // namespace

Command declare_places(CLI::App& infuse) {
  CLI::App* app = add_tool(infuse, *find_tool("places"));
  const auto arguments = std::make_shared<PlacesArguments>();
  app->add_option("PLACES", arguments->places,
                  "a drive folder with a camera, or a folder of images in order of their names")
      ->required();
  app->add_option("QUERIES", arguments->queries,
                  "the same: images that were taken in the same direction")
      ->required();
  app->add_option("--camera", arguments->camera, "camera, if there are several")->type_name("NAME");
  app->add_option("--length", arguments->length,
                  "images of the query that are matched together (default: 21)")
      ->check(CLI::Range(1, 1000))
      ->type_name("N");
  app->add_option("--max-chance", arguments->max_chance,
                  "an image counts as found if so good a match is no more probable than this by "
                  "chance (default: 0.02)")
      ->check(CLI::Range(0.0001, 1.0))
      ->type_name("P");
  app->add_option("-o,--output", arguments->output, "table of the answers to write")
      ->type_name("FILE.csv");
  app->add_flag("--json", arguments->json, "print summary and answers as one JSON object");
  set_examples(*app, {"infuse places summer/ winter/ -o found.csv",
                      "infuse places images_monday/ images_tuesday/ --length 9 --json"});
  return {app, [=] { return run_places(*arguments); }};
}

}  // namespace infuse::daemon
