#include "daemon/tools/places/places.hpp"

#include <spdlog/fmt/fmt.h>

#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/protocol/json.hpp"
#include "daemon/tools/places/comparison.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kPlacesProgram = "infuse places";

struct PlacesArguments {
  ComparisonRequest request;
  std::string output;
  double max_chance = 0.02;
  bool json = false;
};

Json answers_json(const Comparison& comparison, double max_chance) {
  const PlaceList& places = comparison.places;
  Json out = Json::array();
  for (size_t i = 0; i < comparison.answers.size(); ++i) {
    const PlaceAnswer& a = comparison.answers[i];
    Json row = {{"query", comparison.queries.names[i]}};
    if (!comparison.queries.stamps.empty()) row["stamp"] = comparison.queries.stamps[i].ns();
    row["place"] = places.names[a.match.place];
    row["index"] = a.match.place;
    if (!places.stamps.empty()) row["place_stamp"] = places.stamps[a.match.place].ns();
    if (a.chance) {
      row["found"] = *a.chance <= max_chance;
      row["chance"] = *a.chance;
    }
    row["score"] = a.match.score;
    row["margin"] = a.match.margin;
    if (a.match.runner_up != a.match.place) row["runner_up"] = places.names[a.match.runner_up];
    out.push_back(std::move(row));
  }
  return out;
}

std::string answers_csv(const Comparison& comparison) {
  const PlaceList& places = comparison.places;
  std::string out = "query,place,chance,score,margin,runner_up\n";
  for (size_t i = 0; i < comparison.answers.size(); ++i) {
    const PlaceAnswer& a = comparison.answers[i];
    out +=
        fmt::format("{},{},{},{:.3f},{:.3f},{}\n", comparison.queries.names[i],
                    places.names[a.match.place], a.chance ? fmt::format("{:.4f}", *a.chance) : "",
                    a.match.score, a.match.margin, places.names[a.match.runner_up]);
  }
  return out;
}

int run_places(const PlacesArguments& arguments) {
  const ComparisonRequest& request = arguments.request;
  const auto comparison = compare_drives(request);
  if (!comparison) return print_error(kPlacesProgram, comparison.error(), kUnreadable);
  size_t found = 0;
  for (const PlaceAnswer& a : comparison->answers)
    found += a.chance && *a.chance <= arguments.max_chance ? 1 : 0;
  if (!arguments.output.empty()) {
    const auto written = text::write_text(arguments.output, answers_csv(*comparison));
    if (!written) return print_error(kPlacesProgram, written.error(), kFailure);
  }
  const size_t queries = comparison->queries.names.size();
  const size_t places = comparison->places.names.size();
  if (arguments.json) {
    std::cout << Json({{"queries", queries},
                       {"places", places},
                       {"method", request.method},
                       {"sequence", request.sequence},
                       {"length", request.length},
                       {"found", found},
                       {"answers", answers_json(*comparison, arguments.max_chance)}})
              << "\n";
  } else if (request.sequence == "none") {
    std::cout << fmt::format(
        "{} queries sought among {} places, one by one: only sequences show which are found by "
        "chance\n",
        queries, places);
  } else {
    std::cout << fmt::format("{} queries sought among {} places by sequences of {}: {} found\n",
                             queries, places, request.length, found);
    if (queries < 3 * request.length)
      std::cout << "too few queries to exclude chance: three times --length are needed\n";
  }
  return found > 0 || request.sequence == "none" ? kDone : kFailure;
}

}  // namespace

Command declare_places(CLI::App& infuse) {
  CLI::App* app = add_tool(infuse, *find_tool("places"));
  const auto arguments = std::make_shared<PlacesArguments>();
  app->add_option("PLACES", arguments->request.places,
                  "a drive, or a folder of images in order of their names")
      ->required();
  app->add_option("QUERIES", arguments->request.queries,
                  "the same: images that were taken in the same direction, or sweeps")
      ->required();
  app->add_option("--camera", arguments->request.camera, "camera, if there are several")
      ->type_name("NAME");
  app->add_option("--lidar", arguments->request.lidar, "lidar, if there are several")
      ->type_name("NAME");
  app->add_option("--method", arguments->request.method,
                  "what is compared: edges (default), correlation or words of images; shape of "
                  "sweeps; total-mi of sweeps, with images if there are any")
      ->check(CLI::IsMember(comparison_methods()));
  app->add_option("--sequence", arguments->request.sequence,
                  "how sequences are compared: none; match (default); by the mutual or directed "
                  "information of codewords of the edges")
      ->check(CLI::IsMember(sequence_methods()));
  app->add_option("--every", arguments->request.every,
                  "sweeps from one place to the next (default: 5)")
      ->check(CLI::Range(1, 10'000))
      ->type_name("N");
  app->add_option("--length", arguments->request.length,
                  "places of the query that are matched together (default: 21)")
      ->check(CLI::Range(1, 1000))
      ->type_name("N");
  app->add_option(
         "--max-chance", arguments->max_chance,
         "a place counts as found if the probability that it is one by chance is at most this "
         "(default: 0.02)")
      ->check(CLI::Range(0.0001, 1.0))
      ->type_name("P");
  app->add_option("-o,--output", arguments->output, "table of the answers to write")
      ->type_name("FILE.csv");
  app->add_flag("--json", arguments->json, "print summary and answers as one JSON object");
  set_examples(*app, {"infuse places summer/ winter/ --length 9 -o found.csv",
                      "infuse places summer/ winter/ --method total-mi --sequence none"});
  return {app, [=] { return run_places(*arguments); }};
}

}  // namespace infuse::daemon
