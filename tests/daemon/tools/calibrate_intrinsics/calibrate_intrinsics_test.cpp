// `infuse calibrate-intrinsics` as a person runs it, on images of a board.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "drivers/camera/png_encoder.hpp"
#include "drivers/recording/drive_toml.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/daemon/schema.hpp"
#include "tests/folders.hpp"
#include "tests/fusion/target/synthetic_views.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

constexpr target::Board kBoard{.columns = 7, .rows = 5, .square_size = 0.03};

CameraIntrinsics webcam() {
  return {.width = 640,
          .height = 480,
          .fx = 520,
          .fy = 522,
          .cx = 327,
          .cy = 233,
          .distortion = {-0.15, 0.08, 0.001, -0.0008, 0}};
}

/// Draws what the camera sees of a board: four rays for each pixel.
class BoardPainter {
 public:
  BoardPainter() {
    const geometry::CameraModel camera(webcam());
    for (int v = 0; v < 2 * webcam().height; ++v) {
      for (int u = 0; u < 2 * webcam().width; ++u)
        rays_.push_back(*camera.unproject({0.5 * u - 0.25, 0.5 * v - 0.25}));
    }
  }

  CameraFrame paint(const Eigen::Isometry3d& T_camera_board) const {
    CameraFrame image{.width = webcam().width, .height = webcam().height};
    const auto across = static_cast<size_t>(2 * webcam().width);
    for (size_t v = 0; v < static_cast<size_t>(image.height); ++v) {
      for (size_t u = 0; u < static_cast<size_t>(image.width); ++u) {
        double sum = 0;
        for (const size_t at : {size_t{0}, size_t{1}, across, across + 1}) {
          sum += target::synthetic::brightness(T_camera_board, kBoard,
                                               rays_[2 * v * across + 2 * u + at])
                     .value_or(110);
        }
        image.pixels.push_back(static_cast<uint8_t>(sum / 4));
      }
    }
    return image;
  }

 private:
  std::vector<Eigen::Vector3d> rays_;
};

/// A board held 0.35 m to 0.55 m from the camera.
Eigen::Isometry3d hold_board(target::synthetic::RandomSource& random) {
  const geometry::CameraModel camera(webcam());
  while (true) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    const double towards = random.uniform(0, 2 * M_PI);
    T.linear() = (Eigen::AngleAxisd(random.uniform(0.3, 0.7),
                                    Eigen::Vector3d(std::cos(towards), std::sin(towards), 0)) *
                  Eigen::AngleAxisd(random.uniform(-0.3, 0.3), Eigen::Vector3d::UnitZ()))
                     .toRotationMatrix();
    const double depth = random.uniform(0.35, 0.55);
    T.translation() =
        depth * Eigen::Vector3d(random.uniform(-0.4, 0.4), random.uniform(-0.3, 0.3), 1) -
        T.linear() * kBoard.middle();
    // with its outermost squares and its white border
    bool seen = true;
    for (const double x : {-1.5, kBoard.columns + 0.5}) {
      for (const double y : {-1.5, kBoard.rows + 0.5}) {
        const auto at = camera.project(T * (kBoard.square_size * Eigen::Vector3d(x, y, 0)));
        seen = seen && at && camera.in_image(*at);
      }
    }
    if (seen) return T;
  }
}

/// Every second pixel of every second row.
CameraFrame halve(const CameraFrame& image) {
  CameraFrame half{.width = image.width / 2, .height = image.height / 2};
  for (int v = 0; v < half.height; ++v) {
    for (int u = 0; u < half.width; ++u)
      half.pixels.push_back(image.pixels[static_cast<size_t>(2 * v * image.width + 2 * u)]);
  }
  return half;
}

void write_bytes(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

class CalibrateIntrinsicsTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<ScratchFolder>();
    fs::create_directory(images());
    const BoardPainter painter;
    target::synthetic::RandomSource random(7);
    for (int k = 0; k < 12; ++k) {
      const CameraFrame image = painter.paint(hold_board(random));
      if (k == 0) small_ = halve(image);
      const auto png = camera::encode_png(image);
      ASSERT_TRUE(png);
      write_bytes(images() / (std::to_string(100 + k) + ".png"), {png->begin(), png->end()});
    }
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static fs::path images() { return *folder_ / "webcam"; }

  /// Runs the command; `output` holds standard output and standard error.
  static ProgramResult run(const std::string& arguments) {
    return run_shell_command("{ " + programs_folder() + "/infuse calibrate-intrinsics " +
                             arguments + "; } 2>&1");
  }

  /// A folder with what is not an image of the board.
  static fs::path rubbish() {
    fs::path folder = *folder_ / "rubbish";
    fs::create_directory(folder);
    write_bytes(folder / "text.png", "not an image\n");
    std::ifstream file(images() / "100.png", std::ios::binary);
    const std::string png{std::istreambuf_iterator<char>(file), {}};
    write_bytes(folder / "truncated.png", png.substr(0, png.size() / 2));
    CameraFrame grey{.width = 320, .height = 240};
    grey.pixels.assign(320 * 240, 90);
    const auto blank = camera::encode_png(grey), small = camera::encode_png(small_);
    write_bytes(folder / "blank.png", {blank->begin(), blank->end()});
    write_bytes(folder / "small.png", {small->begin(), small->end()});
    return folder;
  }

  static std::unique_ptr<ScratchFolder> folder_;
  static CameraFrame small_;  // an image of the board in half the size
};
CameraFrame CalibrateIntrinsicsTest::small_;
std::unique_ptr<ScratchFolder> CalibrateIntrinsicsTest::folder_;

TEST_F(CalibrateIntrinsicsTest, FindsTheCameraAndWritesItsRig) {
  const fs::path rig_file = *folder_ / "rig.toml", plot = *folder_ / "plot.png";
  const ProgramResult result = run(images().string() + " " + rubbish().string() +
                                   " --board 7x5 --square 0.03 --camera front --json -o " +
                                   rig_file.string() + " --plot " + plot.string());
  ASSERT_EQ(result.code, 0) << result.output;
  ASSERT_TRUE(is_result(result.output, "calibrate-intrinsics"));
  const json found = json::parse(result.output);
  EXPECT_EQ(found["views_used"], 12);
  EXPECT_EQ(found["skipped"].size(), 4U);
  EXPECT_THAT(result.output, HasSubstr("small.png: 320 × 240 pixels, most images have 640 × 480"));
  EXPECT_LT(found["rms_px"], 0.2);
  for (const auto& [name, truth] : {std::pair{"fx", webcam().fx},
                                    {"fy", webcam().fy},
                                    {"cx", webcam().cx},
                                    {"cy", webcam().cy}}) {
    const double sigma = found["intrinsics"]["sigma"][name];
    EXPECT_NEAR(found["intrinsics"][name], truth, 3.5 * sigma) << name;
    EXPECT_LT(sigma, 1.5) << name;
  }
  const auto rig = recording::read_vehicle_rig(rig_file);
  ASSERT_TRUE(rig) << rig.error().message();
  ASSERT_NE(rig->find_camera("front"), nullptr);
  EXPECT_EQ(rig->find_camera("front")->intrinsics.fx, found["intrinsics"]["fx"]);
  EXPECT_GT(fs::file_size(plot), 1000U);

  // Again with another camera: the first one stays.
  const ProgramResult second =
      run(images().string() + " --board 7x5 --camera rear -o " + rig_file.string());
  ASSERT_EQ(second.code, 0) << second.output;
  EXPECT_THAT(second.output, HasSubstr("usable, from 12 views"));
  const auto both = recording::read_vehicle_rig(rig_file);
  ASSERT_TRUE(both) << both.error().message();
  EXPECT_EQ(both->cameras.size(), 2U);
}

TEST_F(CalibrateIntrinsicsTest, RefusesWhatIsNoBoard) {
  const ProgramResult none = run(rubbish().string() + " --board 9x6 --json");
  EXPECT_EQ(none.code, 1) << none.output;
  EXPECT_TRUE(is_result(none.output, "calibrate-intrinsics"));
  EXPECT_THAT(none.output, HasSubstr("0 views of the board"));
  EXPECT_EQ(run("/nowhere --board 7x5").code, 3);
  fs::create_directory(*folder_ / "empty");
  const ProgramResult empty = run((*folder_ / "empty").string() + " --board 7x5");
  EXPECT_EQ(empty.code, 3);
  EXPECT_THAT(empty.output, HasSubstr("there are no images"));
  for (const char* wrong : {"7", "7x5x", "2x2", "999x5"})
    EXPECT_EQ(run(images().string() + " --board " + wrong).code, 2) << wrong;
  EXPECT_EQ(run(images().string() + " --board 7x5 --model spherical").code, 2);
}

}  // namespace
}  // namespace infuse::daemon
