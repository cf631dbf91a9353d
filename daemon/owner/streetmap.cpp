#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/command_line/progress_line.hpp"
#include "daemon/drawing/plan_legend.hpp"
#include "daemon/owner/commands.hpp"
#include "daemon/protocol/json.hpp"
#include "daemon/streetmap/street_map_file.hpp"
#include "drivers/camera/png_encoder.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/recording/atomic_file.hpp"
#include "fusion/streetmap/draw_map.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kStreetMapProgram = "infuse streetmap";

struct StreetMapArguments {
  std::string input;
  std::string output;
  std::string image;
  std::optional<double> cell;
  std::vector<double> clip;  // degrees: west, south, east, north
  std::optional<double> scale;
  double edge = streetmap::ImageMapOptions().edge_threshold;
  bool json = false;
};

/// Number of segments of each kind, without those that only mark streets on other levels.
std::array<uint64_t, streetmap::kSegmentKindCount> count_kinds(const streetmap::SegmentMap& map) {
  std::array<uint64_t, streetmap::kSegmentKindCount> counts{};
  for (uint32_t id = 1; id < map.segment_count(); ++id) {
    const streetmap::Segment segment = map.segment(id);
    if (segment.levels != streetmap::StreetLevels::kOne) continue;
    ++counts[static_cast<size_t>(segment.kind)];
  }
  return counts;
}

Result<void> write_image(const streetmap::SegmentMap& map, const std::string& path) {
  CameraFrame image = streetmap::draw_map(map);
  PlanLegend legend{map.columns() * map.frame().cell_size / std::max(1, image.width), true, {}};
  const auto counts = count_kinds(map);
  for (size_t kind = 1; kind < counts.size(); ++kind) {
    const auto one = static_cast<streetmap::SegmentKind>(kind);
    if (counts[kind] > 0) {
      legend.colours.push_back({streetmap::name_of(one), streetmap::drawn_colour(one)});
    }
  }
  add_legend(image, legend);
  const auto png = camera::encode_png(image);
  if (!png) return tl::unexpected(png.error());
  return recording::write_file_atomically(path, std::as_bytes(std::span(*png)));
}

Json map_json(const StreetMapArguments& arguments, const streetmap::SegmentMap& map, size_t bytes,
              const std::vector<Error>& warnings) {
  const streetmap::MapFrame& frame = map.frame();
  Json json = {{"map", arguments.output},
               {"segments", map.segment_count() - 1},
               {"width_m", map.columns() * frame.cell_size},
               {"height_m", map.rows() * frame.cell_size},
               {"cell_m", frame.cell_size},
               {"bytes", bytes},
               {"warnings", Json::array()}};
  if (frame.georeferenced) {
    json["latitude_deg"] = frame.latitude / kDegree;
    json["longitude_deg"] = frame.longitude / kDegree;
  }
  const auto counts = count_kinds(map);
  for (size_t kind = 1; kind < counts.size(); ++kind) {
    if (counts[kind] == 0) continue;
    json["kinds"][streetmap::name_of(static_cast<streetmap::SegmentKind>(kind))] = counts[kind];
  }
  for (const Error& warning : warnings) json["warnings"].push_back(warning.message());
  return json;
}

void print_map(const StreetMapArguments& arguments, const streetmap::SegmentMap& map, size_t bytes,
               const std::vector<Error>& warnings) {
  const streetmap::MapFrame& frame = map.frame();
  for (const Error& warning : warnings)
    std::cerr << kStreetMapProgram << ": " << warning.message() << "\n";
  std::cout << fmt::format("{}: {:.2f} km × {:.2f} km in cells of {:g} m, {} segments, {:.1f} MB\n",
                           arguments.output, map.columns() * frame.cell_size / 1000,
                           map.rows() * frame.cell_size / 1000, frame.cell_size,
                           map.segment_count() - 1, static_cast<double>(bytes) / 1e6);
  const auto counts = count_kinds(map);
  for (size_t kind = 1; kind < counts.size(); ++kind) {
    if (counts[kind] == 0) continue;
    std::cout << fmt::format("  {:6} {}\n", counts[kind],
                             streetmap::name_of(static_cast<streetmap::SegmentKind>(kind)));
  }
  if (frame.georeferenced) {
    std::cout << fmt::format("  origin {:.7f}° N {:.7f}° E\n", frame.latitude / kDegree,
                             frame.longitude / kDegree);
  }
}

/// Bounds of --clip.
Result<osm::Bounds> clip_of(const std::vector<double>& degrees) {
  const double west = degrees[0], south = degrees[1], east = degrees[2], north = degrees[3];
  if (!(west >= -180 && west < east && east <= 180 && south >= -90 && south < north &&
        north <= 90)) {
    return fail("is not a rectangle", "--clip", "give WEST,SOUTH,EAST,NORTH in degrees");
  }
  return osm::Bounds{south * kDegree, west * kDegree, north * kDegree, east * kDegree};
}

/// Shows what takes long: a bar on a terminal, else a line every tenth after five seconds.
class SlowProgress {
 public:
  void show(std::optional<double> share, const std::string& what) {
    const auto passed = std::chrono::steady_clock::now() - start_;
    if (passed > std::chrono::milliseconds(500)) line_.show(share, what);
    if (line_.visible() || !share || passed < std::chrono::seconds(5)) return;
    const int tenth = static_cast<int>(*share * 10);
    if (tenth == shown_tenth_) return;
    shown_tenth_ = tenth;
    std::cerr << fmt::format("{}: {} {} %\n", kStreetMapProgram, what, tenth * 10);
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  ProgressLine line_;
  int shown_tenth_ = 0;
};

int run(const StreetMapArguments& arguments) {
  StreetMapOptions options;
  if (is_image_file(arguments.input)) {
    if (!arguments.scale) {
      return print_error(
          kStreetMapProgram,
          {"an image needs a scale", arguments.input, "give the metres per pixel: --scale METRES"},
          kUsage);
    }
    options.image = {.metres_per_pixel = *arguments.scale, .edge_threshold = arguments.edge};
    if (const auto wrong = options.image->invalid()) {
      return print_error(kStreetMapProgram, {*wrong, "", ""}, kUsage);
    }
  } else if (arguments.cell) {
    options.raster.cell_size = *arguments.cell;
  }
  if (!arguments.clip.empty()) {
    const auto clip = clip_of(arguments.clip);
    if (!clip) return print_error(kStreetMapProgram, clip.error(), kUsage);
    options.clip = *clip;
  }
  if (const auto wrong = options.raster.invalid()) {
    return print_error(kStreetMapProgram, {*wrong, "--cell", ""}, kUsage);
  }
  Result<GeneratedStreetMap> made;
  {
    SlowProgress progress;
    options.progress = [&](auto share, const auto& what) { progress.show(share, what); };
    made = make_street_map(arguments.input, options);
  }
  if (!made) return print_error(kStreetMapProgram, made.error(), kUnreadable);
  if (const auto written = recording::write_file_atomically(arguments.output, made->bytes);
      !written) {
    return print_error(kStreetMapProgram, written.error(), kFailure);
  }
  // Open the written file, as the daemon will.
  const auto opened = open_street_map_file(arguments.output);
  if (!opened) return print_error(kStreetMapProgram, opened.error(), kFailure);
  if (!arguments.image.empty()) {
    if (const auto drawn = write_image(opened->map, arguments.image); !drawn) {
      return print_error(kStreetMapProgram, drawn.error(), kFailure);
    }
  }
  if (arguments.json) {
    std::cout << json_text(map_json(arguments, opened->map, made->bytes.size(), made->warnings))
              << "\n";
  } else {
    print_map(arguments, opened->map, made->bytes.size(), made->warnings);
  }
  return kDone;
}

}  // namespace

Command declare_streetmap(CLI::App& infuse) {
  CLI::App* app = infuse.add_subcommand(
      "streetmap",
      "make a street map from OpenStreetMap (.osm, .osm.bz2, .osm.gz, .osm.pbf) or from an image");
  const auto arguments = std::make_shared<StreetMapArguments>();
  app->add_option("INPUT", arguments->input,
                  "an .osm file, or a .png or .jpg image of a map, north up")
      ->required();
  app->add_option("-o,--output", arguments->output, "street map to write")
      ->required()
      ->type_name("MAP");
  app->add_option("--image", arguments->image,
                  "write an image of the map too, with a scale and a legend")
      ->type_name("FILE.png");
  app->add_option("--cell", arguments->cell, "edge length of a raster cell (0.2)")->type_name("M");
  app->add_option("--clip", arguments->clip, "use only this rectangle, degrees")
      ->type_name("WEST,SOUTH,EAST,NORTH")
      ->delimiter(',')
      ->expected(4);
  app->add_option("--scale", arguments->scale, "for an image: metres per pixel")->type_name("M");
  app->add_option("--edge", arguments->edge,
                  "for an image: minimum Sobel magnitude of a line (60)");
  app->add_flag("--json", arguments->json, "print the result as one JSON object");
  set_examples(*app, {"infuse streetmap town.osm.pbf --clip 8.37,48.97,8.43,49.01 -o town.map",
                      "infuse streetmap plan.png --scale 0.2 -o plan.map"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon
