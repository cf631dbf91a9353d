#include "daemon/tools/calibrate_intrinsics/calibrate_intrinsics.hpp"

#include <cmath>
#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/tools/calibrate_intrinsics/board_images.hpp"
#include "daemon/tools/calibrate_intrinsics/intrinsics_format.hpp"
#include "daemon/tools/calibrate_intrinsics/intrinsics_plot.hpp"
#include "daemon/tools/calibrate_intrinsics/intrinsics_rig.hpp"
#include "drivers/camera/png_encoder.hpp"
#include "drivers/recording/atomic_file.hpp"
#include "drivers/recording/rig_checks.hpp"
#include "fusion/target/calibrate_intrinsics.hpp"
#include "fusion/target/choose_views.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kCalibrateIntrinsicsProgram = "infuse calibrate-intrinsics";
constexpr double kMinMotion = 0.02;  // of the image's diagonal, between two views

struct CalibrateIntrinsicsArguments {
  std::vector<std::string> inputs;
  std::string camera;
  std::string board;
  std::string model = "pinhole";
  std::string plot;
  std::string output;
  target::Board size;
  size_t max_views = 60;
  bool json = false;
};

/// Keeps the views that differ.
void thin_views(size_t max_views, BoardImages& images) {
  const auto chosen = target::choose_views(images.views, max_views,
                                           kMinMotion * std::hypot(images.width, images.height));
  for (size_t k = 0; k < chosen.size(); ++k) {
    if (chosen[k] == k) continue;
    images.views[k] = std::move(images.views[chosen[k]]);
    images.names[k] = std::move(images.names[chosen[k]]);
  }
  images.views.resize(chosen.size());
  images.names.resize(chosen.size());
}

target::IntrinsicsResult calibrate(const CalibrateIntrinsicsArguments& arguments,
                                   const BoardImages& images) {
  CameraIntrinsics camera{.width = images.width, .height = images.height};
  if (arguments.model == "fisheye") camera.model = CameraIntrinsics::Model::kFisheye;
  auto result = target::calibrate_intrinsics(camera, arguments.size, images.views, {});
  if (!result.usable()) return result;
  if (const auto wrong = recording::find_impossible(result.camera))
    result.reason = *wrong + ": add views that reach the image's edges";
  return result;
}

Result<void> write_plot(const std::string& path, const target::IntrinsicsResult& result,
                        const BoardImages& images) {
  const auto png = camera::encode_png(draw_intrinsics(result, images.views));
  if (!png) return tl::unexpected(png.error());
  return recording::write_file_atomically(path, std::as_bytes(std::span(*png)));
}

int run(CalibrateIntrinsicsArguments& arguments) {
  const auto usage = [](const Error& error) {
    return print_error(kCalibrateIntrinsicsProgram, error, kUsage);
  };
  if (!arguments.size.set_corners(arguments.board))
    return usage({"'" + arguments.board + "' is not COLSxROWS", "--board", "for example 9x6"});
  if (const auto wrong = arguments.size.invalid()) return usage({*wrong, "", ""});
  auto images = find_board_images(arguments.inputs, arguments.camera, arguments.size);
  if (!images) return print_error(kCalibrateIntrinsicsProgram, images.error(), kUnreadable);
  thin_views(arguments.max_views, *images);
  const target::IntrinsicsResult result = calibrate(arguments, *images);
  if (arguments.json) {
    std::cout << json_text(to_json(*images, result)) << "\n";
  } else {
    std::cout << to_text(*images, result);
  }
  if (!arguments.plot.empty() && result.covariance.size() > 0) {
    if (const auto written = write_plot(arguments.plot, result, *images); !written)
      return print_error(kCalibrateIntrinsicsProgram, written.error(), kFailure);
  }
  if (!result.usable()) return kFailure;
  if (arguments.output.empty()) return kDone;
  const std::string& name = arguments.camera.empty() ? images->camera : arguments.camera;
  const auto added =
      write_intrinsics(arguments.output, images->rig, name, result.camera, stated_sigma(result));
  if (!added) return print_error(kCalibrateIntrinsicsProgram, added.error(), kFailure);
  if (*added) {
    std::cerr << kCalibrateIntrinsicsProgram << ": note: the camera is new in " << arguments.output
              << ": its pose there is a guess (infuse calibrate)\n";
  }
  return kDone;
}

}  // namespace

Command declare_calibrate_intrinsics(CLI::App& infuse) {
  CLI::App* app = add_tool(infuse, *find_tool("calibrate-intrinsics"));
  const auto arguments = std::make_shared<CalibrateIntrinsicsArguments>();
  app->add_option("INPUT", arguments->inputs,
                  "folders of PNG or JPEG images, or drives, of one camera")
      ->required();
  app->add_option("--camera", arguments->camera,
                  "camera of the drive, if it has several; camera of the rig that -o writes")
      ->type_name("NAME");
  app->add_option("--board", arguments->board, "inner corners of the board, e.g. 9x6")
      ->required()
      ->type_name("COLSxROWS");
  app->add_option(
         "--square", arguments->size.square_size,
         "side length of a square (0.1): a wrong one changes distances, not the focal length")
      ->type_name("M");
  app->add_option("--model", arguments->model,
                  "pinhole: Brown–Conrady distortion; fisheye: Kannala–Brandt (pinhole)")
      ->check(CLI::IsMember({"pinhole", "fisheye"}))
      ->type_name("MODEL");
  app->add_option("--max-views", arguments->max_views,
                  "use at most so many views, those that differ most (60)")
      ->check(CLI::Range(8, 1000))
      ->type_name("N");
  app->add_option("--plot", arguments->plot,
                  "draw the corners' errors, and where in the image corners are")
      ->type_name("FILE.png");
  app->add_option("-o,--output", arguments->output,
                  "write the intrinsics into this rig, if they are usable; without such a file, "
                  "into the drive's rig or a new one")
      ->type_name("rig.toml");
  app->add_flag("--json", arguments->json, "print the result as one JSON object");
  set_examples(*app,
               {"infuse calibrate-intrinsics images/ --board 9x6 --square 0.025 -o rig.toml",
                "infuse calibrate-intrinsics drive/ --camera left --board 7x5 --model fisheye "
                "--plot errors.png"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon
