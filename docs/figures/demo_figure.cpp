// demo-figure: draws docs/figures/demo.jpg from the demo's drive and its replay. Run by `./dev
// figures`.
//
//   demo-figure DRIVE REPORTS.jsonl TRACK.tum MAP -o FILE.jpg
//
// Left: the lidar's returns over one image, with the calibration that the drive states and with the
// one in use at the end. Right: the street map with the true path and the track.

#include <spdlog/fmt/fmt.h>

#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "daemon/command_line/arguments.hpp"
#include "daemon/drawing/calibration_images.hpp"
#include "daemon/playback/calibration_scenes.hpp"
#include "daemon/streetmap/street_map_file.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "fixtures/simulator/sensors/image_file.hpp"
#include "fusion/streetmap/draw_map.hpp"

namespace infuse {
namespace {

constexpr int kHeight = 720;        // pixels of the figure
constexpr int kMapWidth = 720;      // pixels
constexpr int kMaxMapCells = 8000;  // so that a map's cell is a pixel
constexpr double kMargin = 25;      // m around the path
// The part of the image that is drawn, as fractions of its size.
constexpr double kPartLeft = 0.4;
constexpr double kPartTop = 0.14;
constexpr double kPartSize = 0.5;
constexpr int kJpegQuality = 82;
const cv::Scalar kTruthColour(255, 255, 255);  // blue, green, red
const cv::Scalar kTrackColour(30, 30, 230);

struct Arguments {
  std::string drive, reports, track, map, output;
  int scene = 12;  // of kScenes, spread over the drive
};
constexpr int kScenes = 20;

cv::Mat to_mat(CameraFrame& frame) {
  return {frame.height, frame.width, CV_8UC3, frame.pixels.data()};
}

void write_caption(cv::Mat& image, const std::string& text) {
  cv::rectangle(image, {0, 0}, {image.cols, 28}, cv::Scalar(255, 255, 255), cv::FILLED);
  cv::putText(image, text, {10, 20}, cv::FONT_HERSHEY_DUPLEX, 0.52, cv::Scalar(40, 40, 40), 1,
              cv::LINE_AA);
}

/// The calibration of the camera in use at the end of a replay.
Result<Eigen::Isometry3d> read_last_calibration(const std::string& reports,
                                                const std::string& camera) {
  std::ifstream file(reports);
  std::optional<Eigen::Isometry3d> T_camera_lidar;
  for (std::string line; std::getline(file, line);) {
    const auto report = nlohmann::json::parse(line, nullptr, false);
    if (report.value("class", "") != "CALIBRATION" || report.value("device", "") != camera)
      continue;
    const auto numbers = report.at("T_camera_lidar").get<std::vector<double>>();
    T_camera_lidar.emplace();
    for (size_t i = 0; i < 16; ++i) {
      T_camera_lidar->matrix()(static_cast<int>(i / 4), static_cast<int>(i % 4)) = numbers.at(i);
    }
  }
  if (!T_camera_lidar) return fail("no CALIBRATION report of " + camera, reports);
  return *T_camera_lidar;
}

cv::Mat overlay_panel(const daemon::ScenePair& pair, const CameraIntrinsics& intrinsics,
                      const Eigen::Isometry3d& T_camera_lidar, const std::string& caption) {
  CameraFrame frame = daemon::draw_overlay(pair, intrinsics, T_camera_lidar);
  const cv::Rect part(
      static_cast<int>(kPartLeft * frame.width), static_cast<int>(kPartTop * frame.height),
      static_cast<int>(kPartSize * frame.width), static_cast<int>(kPartSize * frame.height));
  cv::Mat panel;
  const double scale = kHeight / 2.0 / part.height;
  cv::resize(to_mat(frame)(part), panel, {}, scale, scale, cv::INTER_LINEAR);
  write_caption(panel, caption);
  return panel;
}

cv::Mat map_panel(const streetmap::SegmentMap& map,
                  const std::vector<recording::TrajectoryPose>& truth,
                  const std::vector<recording::TrajectoryPose>& track) {
  CameraFrame frame = streetmap::draw_map(map, kMaxMapCells);
  cv::Mat image = to_mat(frame);
  const double cells_per_m = frame.width / (map.columns() * map.frame().cell_size);
  const auto pixels = [&](const std::vector<recording::TrajectoryPose>& poses) {
    std::vector<cv::Point> line;
    for (const auto& pose : poses) {
      const Eigen::Vector2d p = pose.T_frame_body.translation().head<2>() - map.frame().min_corner;
      line.emplace_back(static_cast<int>(p.x() * cells_per_m),
                        frame.height - 1 - static_cast<int>(p.y() * cells_per_m));
    }
    return line;
  };
  const std::vector<cv::Point> true_path = pixels(truth);
  const std::vector<cv::Point> tracked = pixels(track);
  const cv::Rect path = cv::boundingRect(true_path);
  const int margin = static_cast<int>(kMargin * cells_per_m);
  const int side = std::max(path.width, path.height) + 2 * margin;
  const cv::Rect square(path.x + path.width / 2 - side / 2, path.y + path.height / 2 - side / 2,
                        side, side);
  cv::polylines(image, true_path, false, kTruthColour, side / 90, cv::LINE_AA);
  cv::polylines(image, tracked, false, kTrackColour, side / 220, cv::LINE_AA);
  const cv::Rect inside = square & cv::Rect(0, 0, image.cols, image.rows);
  cv::Mat cropped(side, side, CV_8UC3, cv::Scalar(222, 232, 235));
  image(inside).copyTo(cropped(inside - square.tl()));
  cv::Mat panel;
  cv::resize(cropped, panel, {kMapWidth, kHeight}, 0, 0, cv::INTER_AREA);
  write_caption(panel, "track on the street map (red), true path (white)");
  return panel;
}

Result<void> draw(const Arguments& arguments) {
  const auto pairs =
      daemon::read_scene_pairs({.drives = {arguments.drive}, .max_scenes = kScenes}, [](double) {});
  if (!pairs) return tl::unexpected(pairs.error());
  const auto scene = static_cast<size_t>(arguments.scene);
  if (scene >= pairs->pairs.size()) return fail("has too few images", arguments.drive);
  const CameraMount& camera = pairs->cameras.front();
  const auto in_use = read_last_calibration(arguments.reports, camera.name);
  if (!in_use) return tl::unexpected(in_use.error());
  auto map = daemon::open_street_map_file(arguments.map);
  if (!map) return tl::unexpected(map.error());
  const auto truth =
      recording::read_trajectory(std::filesystem::path(arguments.drive) / "truth" / "poses.tum");
  if (!truth) return tl::unexpected(truth.error());
  const auto track = recording::read_trajectory(arguments.track);
  if (!track) return tl::unexpected(track.error());

  cv::Mat left, figure;
  cv::vconcat(overlay_panel(pairs->pairs[scene], camera.intrinsics, camera.T_camera_lidar,
                            "lidar over the image of a knocked camera"),
              overlay_panel(pairs->pairs[scene], camera.intrinsics, *in_use,
                            "the same, recalibrated while driving"),
              left);
  cv::hconcat(left, map_panel(map->map, *truth, *track), figure);
  CameraFrame out;
  out.width = figure.cols;
  out.height = figure.rows;
  out.format = PixelFormat::kBgr8;
  out.pixels.assign(figure.datastart, figure.dataend);
  return simulator::write_file(arguments.output, simulator::encode_jpeg(out, kJpegQuality));
}

}  // namespace
}  // namespace infuse

int main(int argc, char** argv) {
  using namespace infuse;
  constexpr const char* kProgram = "demo-figure";
  CLI::App app("demo-figure: the figure of the README, from the demo's drive and its replay");
  Arguments arguments;
  app.add_option("DRIVE", arguments.drive, "drive with its truth")->required();
  app.add_option("REPORTS", arguments.reports, "its reports file")->required();
  app.add_option("TRACK", arguments.track, "its trajectory on the map, TUM format")->required();
  app.add_option("MAP", arguments.map, "the street map")->required();
  app.add_option("-o,--output", arguments.output, "JPEG to write")->required();
  app.add_option("--scene", arguments.scene, "image to draw, of 20 spread over the drive (12)")
      ->check(CLI::Range(0, kScenes - 1));
  if (const auto code = daemon::parse_arguments(app, argc, argv)) return *code;
  if (const auto drawn = draw(arguments); !drawn) {
    return daemon::print_error(kProgram, drawn.error(), daemon::kUnreadable);
  }
  return daemon::kDone;
}
