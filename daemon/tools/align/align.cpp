#include "daemon/tools/align/align.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <iostream>
#include <memory>
#include <optional>

#include "daemon/command_line/arguments.hpp"
#include "daemon/drawing/sweep_image.hpp"
#include "daemon/protocol/json_encoder.hpp"
#include "daemon/tools/align/align_scan.hpp"
#include "drivers/camera/png_encoder.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/text/numbers.hpp"
#include "drivers/text/text_file.hpp"
#include "fusion/registration/gicp.hpp"
#include "fusion/registration/global_guess.hpp"
#include "fusion/registration/visual/align_scans.hpp"
#include "fusion/registration/visual/visual_alignment.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kAlignProgram = "infuse align";

struct Arguments {
  std::string target, source;
  std::string method;
  std::string guess;
  std::string lidar;
  std::string output;
  bool json = false;

  std::string chosen_method() const {
    return !method.empty() ? method : guess.empty() ? "global" : "gicp";
  }
  bool needs_images() const { return method == "vb-gicp" || method == "mi"; }
};

/// Parses "X,Y,YAW" or "X,Y,Z,ROLL,PITCH,YAW", metres and degrees.
std::optional<Eigen::Isometry3d> parse_pose(std::string text) {
  for (char& c : text) c = c == ',' ? ' ' : c;
  const auto numbers = text::parse_numbers(text);
  if (!numbers || (numbers->size() != 3 && numbers->size() != 6)) return std::nullopt;
  const std::vector<double>& n = *numbers;
  const bool planar = n.size() == 3;
  const auto turn = [](double angle_deg, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(angle_deg * kDegree, axis);
  };
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(n[0], n[1], planar ? 0 : n[2]);
  T.linear() = (turn(planar ? n[2] : n[5], Eigen::Vector3d::UnitZ()) *
                turn(planar ? 0 : n[4], Eigen::Vector3d::UnitY()) *
                turn(planar ? 0 : n[3], Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  return T;
}

/// Roll, pitch and yaw, degrees.
Eigen::Vector3d angles_deg(const Eigen::Matrix3d& R) {
  return Eigen::Vector3d(std::atan2(R(2, 1), R(2, 2)), std::asin(std::clamp(-R(2, 0), -1.0, 1.0)),
                         std::atan2(R(1, 0), R(0, 0))) /
         kDegree;
}

geometry::PointsView points_of(const Sweep& sweep) { return {sweep.x, sweep.y, sweep.z}; }

std::vector<registration::ScanImage> images_of(const AlignScan& scan) {
  std::vector<registration::ScanImage> images;
  for (size_t k = 0; k < scan.images.size(); ++k) {
    images.push_back({scan.images[k], scan.cameras[k]});
  }
  return images;
}

/// An alignment by images.
Result<registration::RegistrationResult> align_by_images(const std::string& method,
                                                         const AlignScan& target,
                                                         const AlignScan& source) {
  const std::vector<registration::ScanImage> images_there = images_of(target);
  const std::vector<registration::ScanImage> images_here = images_of(source);
  const registration::CameraLidarScan there{features::make_sweep_view(target.sweep), images_there};
  const registration::CameraLidarScan here{features::make_sweep_view(source.sweep), images_here};
  if (method == "mi") return registration::align_scans_by_information(there, here);
  return registration::align_by_keypoints(there, here).map([](const auto& found) {
    return found.result;
  });
}

/// A pose that the geometry does not determine is that of the guess: no answer.
void refuse_free_directions(registration::RegistrationResult& result) {
  if (result.usable() && result.free_directions > 0)
    result.reason = "the geometry does not determine the pose in all directions";
}

Result<registration::RegistrationResult> align(const Arguments& arguments, const AlignScan& target,
                                               const AlignScan& source, Eigen::Isometry3d guess) {
  const std::string method = arguments.chosen_method();
  if (method != "gicp") {
    auto found = method == "global" ? registration::find_global_guess(points_of(target.sweep),
                                                                      points_of(source.sweep))
                                    : align_by_images(method, target, source);
    if (!found || !found->usable() || method == "vb-gicp") return found;
    guess = found->T_target_source;
  }
  const auto options = registration::sweep_options();
  const auto there = registration::prepare_cloud(points_of(target.sweep), options);
  const auto here = registration::prepare_cloud(points_of(source.sweep), options);
  return registration::gicp(there, here.cloud, guess);
}

void print_json(const Arguments& arguments, const AlignScan& target, const AlignScan& source,
                const registration::RegistrationResult& result) {
  Json out{{"method", arguments.chosen_method()}, {"usable", result.usable()}};
  if (!result.usable()) {
    out["reason"] = result.reason;
  } else {
    out["T_target_source"] = encode(result.T_target_source);
    out["covariance"] = encode(result.covariance);
    out["inliers"] = result.inliers;
    out["points"] = result.points;
    out["rms_m"] = result.rms;
  }
  if (result.free_directions > 0) out["free_directions"] = result.free_directions_text();
  if (!target.deskew_reason.empty()) out["target_not_deskewed"] = target.deskew_reason;
  if (!source.deskew_reason.empty()) out["source_not_deskewed"] = source.deskew_reason;
  std::cout << out.dump() << "\n";
}

void print_text(const Arguments& arguments, const AlignScan& target, const AlignScan& source,
                const registration::RegistrationResult& result) {
  const Eigen::Vector3d t = result.T_target_source.translation();
  const Eigen::Vector3d angles = angles_deg(result.T_target_source.linear());
  const geometry::Vector6 sigma = result.covariance.diagonal().cwiseSqrt();
  std::cout << fmt::format("T_target_source by {}, {} of {} points with a counterpart\n",
                           arguments.chosen_method(), result.inliers, result.points)
            << fmt::format(
                   "  x {:.3f}, y {:.3f}, z {:.3f} m; roll {:.3f}, pitch {:.3f}, yaw "
                   "{:.3f} degrees\n",
                   t.x(), t.y(), t.z(), angles.x(), angles.y(), angles.z())
            << fmt::format(
                   "  standard deviation {:.4f}, {:.4f}, {:.4f} m; {:.4f}, {:.4f}, {:.4f} "
                   "degrees\n",
                   sigma(3), sigma(4), sigma(5), sigma(0) / kDegree, sigma(1) / kDegree,
                   sigma(2) / kDegree);
  for (const auto& [which, scan] : {std::pair{"target", &target}, std::pair{"source", &source}}) {
    if (!scan->deskew_reason.empty()) {
      std::cout << fmt::format("  {} not deskewed: {}\n", which, scan->deskew_reason);
    }
  }
}

int run(const Arguments& arguments) {
  Eigen::Isometry3d guess = Eigen::Isometry3d::Identity();
  if (!arguments.guess.empty()) {
    const auto parsed = parse_pose(arguments.guess);
    if (!parsed) {
      return print_error(kAlignProgram,
                         {"cannot be read: '" + arguments.guess + "'", "--guess",
                          "expected X,Y,YAW or X,Y,Z,ROLL,PITCH,YAW in metres and degrees"},
                         kUsage);
    }
    if (arguments.chosen_method() != "gicp") {
      return print_error(
          kAlignProgram,
          {"only gicp needs a guess", "--guess", "leave it out or use --method gicp"}, kUsage);
    }
    guess = *parsed;
  }
  if (!arguments.output.empty() && std::filesystem::path(arguments.output).extension() != ".png") {
    return print_error(kAlignProgram, {"must be a .png file", "--output", ""}, kUsage);
  }
  const auto target = read_align_scan(arguments.target, arguments.lidar, arguments.needs_images());
  if (!target) return print_error(kAlignProgram, target.error(), kUnreadable);
  const auto source = read_align_scan(arguments.source, arguments.lidar, arguments.needs_images());
  if (!source) return print_error(kAlignProgram, source.error(), kUnreadable);
  auto aligned = align(arguments, *target, *source, guess);
  if (!aligned) return print_error(kAlignProgram, aligned.error(), kUnreadable);
  refuse_free_directions(*aligned);
  const registration::RegistrationResult& result = *aligned;
  if (!arguments.output.empty() && result.usable()) {
    const auto written =
        camera::encode_png(
            draw_alignment(target->sweep, source->sweep, guess, result.T_target_source))
            .and_then([&](const auto& png) {
              return text::write_text(arguments.output,
                                      {reinterpret_cast<const char*>(png.data()), png.size()});
            });
    if (!written) return print_error(kAlignProgram, written.error(), kFailure);
  }
  if (arguments.json) print_json(arguments, *target, *source, result);
  if (!result.usable()) {
    return arguments.json
               ? int{kFailure}
               : print_error(kAlignProgram,
                             {result.reason, arguments.source, result.free_directions_text()},
                             kFailure);
  }
  if (!arguments.json) print_text(arguments, *target, *source, result);
  return kDone;
}

}  // namespace

Command declare_align(CLI::App& infuse) {
  CLI::App* app = add_tool(infuse, *find_tool("align"));
  const auto arguments = std::make_shared<Arguments>();
  app->add_option("TARGET", arguments->target,
                  "sweep INDEX (from 0) of a drive or capture as PATH:INDEX, or a .pcd, .ply or "
                  ".bin file")
      ->required();
  app->add_option("SOURCE", arguments->source, "the sweep whose pose is sought")->required();
  app->add_option(
         "--method", arguments->method,
         "gicp (from a guess); from none: global, or of a drive with cameras vb-gicp (keypoints of "
         "the images) or mi (mutual information); default: global, or gicp with --guess")
      ->check(CLI::IsMember({"gicp", "global", "vb-gicp", "mi"}));
  app->add_option("--guess", arguments->guess,
                  "T_target_source to begin with, metres and degrees: X,Y,YAW or "
                  "X,Y,Z,ROLL,PITCH,YAW (gicp without it: 0)")
      ->type_name("POSE");
  app->add_option("--lidar", arguments->lidar, "lidar, if there are several")->type_name("NAME");
  app->add_option("-o,--output", arguments->output,
                  "draw both sweeps from above: before (left) and after")
      ->type_name("FILE.png");
  app->add_flag("--json", arguments->json, "print the result as one JSON object");
  set_examples(*app, {"infuse align drive/:0 drive/:10 -o aligned.png",
                      "infuse align target.ply source.ply --guess 0.5,0,3"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon
