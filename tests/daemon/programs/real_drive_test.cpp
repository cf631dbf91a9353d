// The main job on a real drive of 51 sweeps, imported and replayed with nothing done by hand.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "daemon/pipeline/odometry_plan.hpp"
#include "daemon/playback/play_lidar.hpp"
#include "daemon/playback/sweep_pairing.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "drivers/camera/image_decoder.hpp"
#include "drivers/import/kitti_import.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/times_csv.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/daemon/schema.hpp"
#include "tests/folders.hpp"
#include "tests/real_data.hpp"

namespace infuse::daemon {
namespace {

using nlohmann::json;
using testing::HasSubstr;

ProgramResult run_quietly(const std::string& command) {
  return run_shell_command(programs_folder() + "/" + command + " 2>/dev/null");
}

class RealDrive : public testing::Test {
 protected:
  void import(const std::filesystem::path& path) {
    const auto imported = importers::import_kitti(path, drive_);
    ASSERT_TRUE(imported) << imported.error().message();
  }

  // Changes drive.toml.
  void edit(const std::function<void(recording::DriveDescription&)>& change) {
    auto drive = recording::Drive::open(drive_);
    ASSERT_TRUE(drive) << drive.error().message();
    change(drive->description);
    ASSERT_TRUE(recording::write_drive_toml(drive_, drive->description));
  }

  // All reports of a replay, in order.
  std::vector<json> replay() {
    const auto reports = folder_ / "reports.jsonl";
    EXPECT_EQ(run_quietly("infused --replay " + drive_.string() + " --reports " + reports.string() +
                          " --socket " + (folder_ / "s").string())
                  .code,
              0);
    std::vector<json> all;
    std::ifstream lines(reports);
    for (std::string line; std::getline(lines, line);) all.push_back(json::parse(line));
    return all;
  }

  static bool any_suspected(const std::vector<json>& reports) {
    return std::any_of(reports.begin(), reports.end(), [](const json& report) {
      return report["class"] == "CALIBRATION" &&
             (report["state"] == "SUSPECTED" || report["state"] == "CONFIRMED");
    });
  }

  json calibrate(const std::string& arguments) {
    const std::string output = run_quietly("infuse calibrate " + drive_.string() +
                                           " --intrinsics-sigma 0.2,0.5,0.005 --json " + arguments)
                                   .output;
    EXPECT_TRUE(is_result(output, "calibrate"));
    return json::parse(output);
  }

  TemporaryFolder folder_;
  std::filesystem::path drive_ = folder_ / "drive";
};

#define IMPORT_OR_SKIP()                                                                         \
  INFUSE_REAL_DATA_OR_SKIP(path, "drives/kitti_raw_0009/2011_09_26/2011_09_26_drive_0009_sync"); \
  import(path)

TEST_F(RealDrive, IsDeskewedAndPairedAndRaisesNoAlert) {
  IMPORT_OR_SKIP();
  size_t sweeps = 0, deskewed = 0, frames = 0;
  const std::vector<json> reports = replay();
  for (const json& report : reports) {
    if (report["class"] == "SWEEP") {
      ++sweeps;
      deskewed += report["deskewed"].get<bool>() ? 1 : 0;
      EXPECT_TRUE(report["has_times"].get<bool>());
    } else if (report["class"] == "FRAME") {
      ++frames;
      EXPECT_EQ(report["sequence"], report["sweep"]) << "image k belongs to sweep k";
      EXPECT_NEAR(report["sweep_offset_s"].get<double>(), 0.0547, 0.0005);
    } else if (report["class"] == "ALERT") {
      // The recording goes on after its last sweep and image.
      EXPECT_THAT(report.dump(), HasSubstr("no data"));
    }
  }
  EXPECT_EQ(sweeps, 51u);
  EXPECT_GE(deskewed, 50u) << "odometry begins after the first sweep";
  EXPECT_EQ(frames, 51u);
  EXPECT_FALSE(any_suspected(reports));
}

TEST_F(RealDrive, ACameraTurnedByOneDegreeAboutAnyAxisIsSuspected) {
  IMPORT_OR_SKIP();
  const auto drive = recording::Drive::open(drive_);
  ASSERT_TRUE(drive) << drive.error().message();
  const Eigen::Isometry3d published = drive->description.rig.cameras[0].T_camera_lidar;
  for (const double degrees : {1.0, -1.0}) {
    for (int axis = 0; axis < 3; ++axis) {
      geometry::Vector6 turn = geometry::Vector6::Zero();
      turn[axis] = degrees * kDegree;
      edit([&](recording::DriveDescription& description) {
        description.rig.cameras[0].T_camera_lidar = geometry::exp(turn) * published;
      });
      EXPECT_TRUE(any_suspected(replay())) << degrees << " degrees about axis " << axis;
    }
  }
}

// Once a vehicle with gyros was taken to stay in a plane, and its deskewed sweeps were blurred.
TEST_F(RealDrive, DeskewedSweepsAreSharperThanMeasuredOnes) {
  IMPORT_OR_SKIP();
  const std::string output =
      run_quietly("infuse evaluate --json --sharpness " + drive_.string()).output;
  EXPECT_TRUE(is_result(output, "evaluate"));
  const json sharp = json::parse(output);
  const json voxels = sharp["voxels_per_point"];
  EXPECT_GE(sharp["sweeps"].get<int>(), 49);
  EXPECT_LT(voxels["deskewed"].get<double>(), voxels["raw"].get<double>());
  EXPECT_LT(voxels["deskewed"].get<double>(), 1.005 * voxels["lidar"].get<double>());
  EXPECT_LT(sharp["p"].get<double>(), 0.01);
}

// There is no other source: infused deskews it by its own motion, and so do the commands.
TEST(RealCapture, ALidarAloneIsDeskewedByDecodeToo) {
  INFUSE_REAL_DATA_OR_SKIP(path, "velodyne/hdl32e-moving.pcap");
  const TemporaryFolder folder;
  const json decoded = json::parse(run_quietly("infuse decode --deskew --json " + path.string() +
                                               " -o " + (folder / "x.pcd").string())
                                       .output);
  EXPECT_GE(decoded["sweeps"].get<int>(), 5);
  EXPECT_LE(decoded["not_deskewed"].get<int>(), 2);
}

TEST_F(RealDrive, SaysWhatItCanBeUsedFor) {
  IMPORT_OR_SKIP();
  const json result = json::parse(run_quietly("infuse inspect --json " + drive_.string()).output);
  ASSERT_EQ(result["uses"].size(), 4u);
  for (size_t k = 0; k < 3; ++k) EXPECT_TRUE(result["uses"][k]["possible"].get<bool>()) << k;
  EXPECT_THAT(result["uses"][3]["statement"].get<std::string>(), HasSubstr("a street map"));
}

// Mean magnitude of the image's gradient at the returns in front of a depth edge, placed as they
// were measured and as they are deskewed.
struct EdgeGradients {
  double measured = 0, deskewed = 0;
  size_t count = 0;

  double gain() const { return deskewed / measured; }
};

std::optional<Eigen::Vector2i> pixel_of(const Sweep& sweep, size_t i, const CameraMount& camera) {
  const CameraIntrinsics& K = camera.intrinsics;
  const Eigen::Vector3d p =
      camera.T_camera_lidar * Eigen::Vector3d(sweep.x[i], sweep.y[i], sweep.z[i]);
  if (p.z() < 1) return std::nullopt;
  const Eigen::Vector2i pixel(std::lround(K.fx * p.x() / p.z() + K.cx),
                              std::lround(K.fy * p.y() / p.z() + K.cy));
  if (pixel.x() < 1 || pixel.y() < 1 || pixel.x() + 1 >= K.width || pixel.y() + 1 >= K.height)
    return std::nullopt;
  return pixel;
}

// Adds the edges that deskewing moves by at least `min_shift` pixels.
void add_edge_gradients(const Sweep& measured, const Sweep& deskewed, const CameraMount& camera,
                        const CameraFrame& frame, double min_shift, EdgeGradients& gradients) {
  const auto at = [&](int x, int y) -> double {
    return frame.pixels[static_cast<size_t>(y * camera.intrinsics.width + x)];
  };
  const auto gradient = [&](const Eigen::Vector2i& p) {
    return 0.5 * std::hypot(at(p.x() + 1, p.y()) - at(p.x() - 1, p.y()),
                            at(p.x(), p.y() + 1) - at(p.x(), p.y() - 1));
  };
  for (size_t i = 0; i + 1 < measured.size(); ++i) {
    const float step = measured.range[i + 1] - measured.range[i];
    if (measured.ring[i] != measured.ring[i + 1] || std::abs(step) < 0.5F) continue;
    const size_t front = step > 0 ? i : i + 1;
    const auto before = pixel_of(measured, front, camera);
    const auto after = pixel_of(deskewed, front, camera);
    if (!before || !after || (*after - *before).cast<double>().norm() < min_shift) continue;
    gradients.measured += gradient(*before);
    gradients.deskewed += gradient(*after);
    ++gradients.count;
  }
}

TEST_F(RealDrive, ImageEdgesAreAtTheDepthEdgesOfDeskewedSweeps) {
  IMPORT_OR_SKIP();
  auto setup = open_drive(drive_, {}, {});
  ASSERT_TRUE(setup) << setup.error().message();
  const CameraMount& camera = setup->rig.cameras[0];
  const auto images = recording::index_images(drive_ / "image_0", camera.stamp_delay);
  ASSERT_TRUE(images);
  SweepPairing pairing(plan_odometry({}, *setup), setup->rig.lidars[0].T_vehicle_lidar, true);
  for (const auto& image : images->entries) pairing.add_exposure(image.stamp);
  std::vector<Sweep> measured;
  play_lidar(
      *setup, 0,
      [&](Sweep& sweep) {
        measured.push_back(sweep);
        pairing.add_sweep(sweep);
      },
      [&](const VehicleSample& sample) { pairing.add_sample(sample); },
      [&](const recording::DriveEvent& event) {
        pairing.advance(event.stamp);
        return true;
      });
  const std::vector<PairedSweep> pairs = pairing.finish();
  ASSERT_EQ(pairs.size(), 51u);
  EdgeGradients all, moved;
  for (size_t k = 1; k < pairs.size(); k += 2) {
    ASSERT_EQ(pairs[k].deskew_reason, "") << k;
    ASSERT_EQ(pairs[k].sweep.sequence, k);
    std::ifstream stream(images->entries[k].path, std::ios::binary);
    const std::vector<uint8_t> bytes{std::istreambuf_iterator<char>(stream), {}};
    CameraFrame frame;
    ASSERT_TRUE(camera::decode_image(bytes, {}, frame));
    add_edge_gradients(measured[k], pairs[k].sweep, camera, frame, 0, all);
    add_edge_gradients(measured[k], pairs[k].sweep, camera, frame, 2, moved);
  }
  // Most edges are ahead, where deskewing hardly moves them.
  EXPECT_GT(all.gain(), 1.04);
  EXPECT_GT(moved.gain(), 1.10);
  std::cout << all.gain() << " of " << all.count << ", moved by 2 pixels " << moved.gain() << " of "
            << moved.count << "\n";
}

// Camera axes: x across, y down, z along the driving direction. Across, the result is 4 cm from the
// published extrinsics, more than the scatter of the scenes explains: what is not known of the
// intrinsics, and what they contradict, is in the stated covariance too. The published ones are
// themselves 1.2 cm off: there is the largest gradient at depth edges, which nothing maximises
// (`infuse-study offset`, fusion/calibration/accuracy.md).
TEST_F(RealDrive, IsCalibratedNearThePublishedExtrinsics) {
  IMPORT_OR_SKIP();
  const json result = calibrate("--perturb 2,0.1 --seed 3");
  // What is contradicted may make it too imprecise to be used, by the limits of --max-sigma.
  if (!result["usable"].get<bool>()) {
    EXPECT_THAT(result["reason"].get<std::string>(), HasSubstr("the standard deviation of"));
  }
  EXPECT_LT(result["error"]["rotation_deg"].get<double>(), 0.15);
  EXPECT_LT(result["error"]["translation_m"].get<double>(), 0.10);
  for (size_t k = 0; k < 6; ++k) {
    const double unit = k < 3 ? M_PI / 180 : 1;
    const double error = unit * result["error"]["by_axis_deg_m"][k].get<double>();
    const double published = k == 3 ? 0.012 : 0;
    const double sigma = std::hypot(std::sqrt(result["covariance"][k][k].get<double>()), published);
    EXPECT_LT(std::abs(error), 3 * sigma) << k;
  }
  EXPECT_NEAR(std::sqrt(result["covariance_of_motion"][5][5].get<double>()), 0.032, 0.002)
      << "3 ms at 10.7 m/s";
}

TEST_F(RealDrive, CalibrationWithoutTimesOfTheReturnsIsRefused) {
  IMPORT_OR_SKIP();
  edit([](recording::DriveDescription& description) { description.lidars[0].turn.reset(); });
  const json result = calibrate("--scenes 12");
  EXPECT_FALSE(result["usable"].get<bool>());
  EXPECT_THAT(result["reason"].get<std::string>(), HasSubstr("speed times time"));
  EXPECT_GT(result["motion_max_shift_m"].get<double>(), 0.3);
}

// A straight street: nothing to close, and its fixes, centimetres good, give the frame.
TEST_F(RealDrive, BecomesAMap) {
  IMPORT_OR_SKIP();
  const std::string map = (folder_ / "map").string();
  const std::string output =
      run_quietly("infuse map " + drive_.string() + " -o " + map + " --json").output;
  EXPECT_TRUE(is_result(output, "map"));
  const json made = json::parse(output);
  EXPECT_TRUE(made["usable"].get<bool>()) << made;
  EXPECT_EQ(made["closures"], 0);
  EXPECT_EQ(made["sweeps"], 51);
  EXPECT_NEAR(made["length_m"].get<double>(), 53, 1.5);
  EXPECT_TRUE(made["georeferenced"].get<bool>());
  EXPECT_LT(made["fixes_rms_m"].get<double>(), 0.3);
  const json scored = json::parse(
      run_quietly("infuse evaluate " + map + "/trajectory.tum " + drive_.string() + " --json")
          .output);
  EXPECT_LT(scored["absolute"]["translation_m"]["rms"].get<double>(), 0.15) << scored;
}

}  // namespace
}  // namespace infuse::daemon
