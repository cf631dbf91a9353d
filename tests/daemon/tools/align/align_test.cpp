// `infuse align` as a person runs it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "drivers/velodyne/velodyne_maker.hpp"
#include "fixtures/scene/capture.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/daemon/schema.hpp"
#include "tests/folders.hpp"
#include "tests/fusion/registration/random_room.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

using nlohmann::json;
using registration::PointCloud;
using registration::random_room;
using testing::HasSubstr;

/// Runs `infuse align`; `output` holds standard output and standard error.
ProgramResult align(const std::string& arguments) {
  return run_shell_command("{ " + programs_folder() + "/infuse align " + arguments + "; } 2>&1");
}

class AlignTest : public testing::Test {
 protected:
  /// Writes a point file; returns its path with a blank on both sides.
  std::string write(const std::string& name, const PointCloud& cloud) const {
    std::ofstream file(folder_ / name);
    file << "ply\nformat ascii 1.0\nelement vertex " << cloud.size()
         << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    for (size_t i = 0; i < cloud.size(); ++i) {
      file << cloud.x[i] << ' ' << cloud.y[i] << ' ' << cloud.z[i] << '\n';
    }
    return " " + (folder_ / name).string() + " ";
  }

  /// A room seen from its middle.
  std::string target() const {
    return write("target.ply", random_room(1, 20'000, 0.01, Eigen::Isometry3d::Identity()));
  }

  ScratchFolder folder_;
};

/// 0.3 m and 3 degrees.
Eigen::Isometry3d small_motion() {
  geometry::Vector6 twist;
  twist << 0, 0, 0.05, 0.3, -0.1, 0.05;
  return geometry::exp(twist);
}

TEST_F(AlignTest, FindsThePoseFromAGuessAndDrawsBoth) {
  const std::string source = write("source.ply", random_room(2, 20'000, 0.01, small_motion()));
  const auto drawing = folder_ / "aligned.png";
  const ProgramResult machine =
      align(target() + source + "--guess 0.2,0,1 --json -o " + drawing.string());
  ASSERT_EQ(machine.code, 0) << machine.output;
  EXPECT_TRUE(is_result(machine.output, "align"));
  const json found = json::parse(machine.output);
  EXPECT_EQ(found["method"], "gicp");
  EXPECT_TRUE(found["usable"]);
  for (Eigen::Index i = 0; i < 16; ++i) {  // by row
    EXPECT_NEAR(found["T_target_source"][static_cast<size_t>(i)].get<double>(),
                small_motion()(i / 4, i % 4), 0.01);
  }
  EXPECT_EQ(found["covariance"].size(), 36U);
  EXPECT_EQ(found["target_not_deskewed"], "the file has no times");
  std::ifstream image(drawing, std::ios::binary);
  std::string magic(4, ' ');
  image.read(magic.data(), 4);
  EXPECT_EQ(magic, "\x89PNG");

  const ProgramResult text = align(target() + source + "--method gicp");
  EXPECT_EQ(text.code, 0);
  EXPECT_THAT(text.output, HasSubstr("yaw 2.8"));
  EXPECT_THAT(text.output, HasSubstr("standard deviation"));
  EXPECT_THAT(text.output, HasSubstr("target not deskewed: the file has no times"));
}

TEST_F(AlignTest, RefusesWrongArguments) {
  const std::string both = target() + target();
  EXPECT_EQ(align(target()).code, 2);
  EXPECT_EQ(align(both + "--method icp").code, 2);
  EXPECT_EQ(align(both + "--guess 1,2").code, 2);
  EXPECT_EQ(align(both + "--guess 1,2,nan").code, 2);
  EXPECT_EQ(align(both + "--method global --guess 1,2,3").code, 2);
  EXPECT_EQ(align(both + "--method mi --guess 1,2,3").code, 2);
  EXPECT_EQ(align(both + "-o x.jpg").code, 2);
  EXPECT_EQ(align(target() + "/nonexistent.pcd").code, 3);
  EXPECT_EQ(align(target() + "/nonexistent:3").code, 3);
}

TEST_F(AlignTest, StatesWhySweepsCannotBeAligned) {
  PointCloud ten = random_room(2, 10, 0.01, Eigen::Isometry3d::Identity());
  PointCloud missing = random_room(2, 2000, 0.01, Eigen::Isometry3d::Identity());
  missing.x.assign(missing.size(), std::numeric_limits<float>::quiet_NaN());
  PointCloud elsewhere = random_room(2, 20'000, 0.01, Eigen::Isometry3d::Identity());
  for (float& x : elsewhere.x) x += 500;
  const std::string there = target();
  const auto reason = [&](const std::string& source, const std::string& method) -> std::string {
    const ProgramResult refused = align(there + source + "--json --method " + method);
    EXPECT_EQ(refused.code, 1) << source << refused.output;
    EXPECT_TRUE(is_result(refused.output, "align"));
    const json found = json::parse(refused.output);
    EXPECT_FALSE(found["usable"]);
    EXPECT_FALSE(found.contains("T_target_source"));
    return found["reason"];
  };
  EXPECT_EQ(reason(write("empty.ply", {}), "gicp"), "the source has no finite points");
  EXPECT_EQ(reason(write("nan.ply", missing), "gicp"), "the source has no finite points");
  EXPECT_EQ(reason(write("ten.ply", ten), "gicp"), "the source has too few points");
  EXPECT_EQ(reason(write("empty.ply", {}), "global"), "the source has too few points");
  EXPECT_EQ(reason(write("nan.ply", missing), "global"), "the source has too few points");
  EXPECT_EQ(reason(write("ten.ply", ten), "global"),
            "no pose agrees with the shapes of both scans");
  EXPECT_THAT(reason(there, "gicp"), HasSubstr("the clouds are identical"));
  EXPECT_THAT(reason(there, "global"), HasSubstr("the clouds are identical"));
  EXPECT_EQ(reason(write("far.ply", elsewhere), "gicp"), "the clouds do not overlap");
}

// On a plane the pose along it is that of the guess: it was given as usable, 100 m unsure.
TEST_F(AlignTest, RefusesAPoseThatThePlaneDoesNotDetermine) {
  const auto floor = [](uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<float> at(-20, 20), noise(-0.02f, 0.02f);
    PointCloud cloud;
    for (int i = 0; i < 8000; ++i) {
      cloud.x.push_back(at(random));
      cloud.y.push_back(at(random));
      cloud.z.push_back(noise(random) - 1.9f);
    }
    return cloud;
  };
  const ProgramResult refused =
      align(write("a.ply", floor(1)) + write("b.ply", floor(2)) + "--json --method gicp");
  EXPECT_EQ(refused.code, 1) << refused.output;
  EXPECT_TRUE(is_result(refused.output, "align"));
  const json found = json::parse(refused.output);
  EXPECT_EQ(found["reason"], "the geometry does not determine the pose in all directions");
  EXPECT_THAT(found["free_directions"].get<std::string>(), HasSubstr("translation along x"));
}

TEST_F(AlignTest, TakesSweepsOfACaptureByTheirIndex) {
  const std::string capture = (folder_ / "street.pcap").string();
  fixtures::CaptureOptions options;
  options.model = &velodyne::lidar_model(velodyne::Model::kVlp16);
  options.duration = from_seconds(1);
  ASSERT_TRUE(fixtures::make_capture(capture, options));
  // Of the wall across the street's end, 60 m ahead, sixteen beams see less than a hundredth: the
  // way along the street is not determined.
  const ProgramResult found = align(capture + ":2 " + capture + ":6 --method gicp --json");
  ASSERT_EQ(found.code, 1) << found.output;
  EXPECT_EQ(json::parse(found.output)["free_directions"], "translation along x");
  const ProgramResult missing = align(capture + ":2 " + capture + ":99");
  EXPECT_EQ(missing.code, 3);
  EXPECT_THAT(missing.output, HasSubstr("has no sweep 99"));
  EXPECT_THAT(align(capture + ":2 " + capture).output, HasSubstr("PATH:INDEX"));
  const ProgramResult blind = align(capture + ":2 " + capture + ":6 --method vb-gicp");
  EXPECT_EQ(blind.code, 3);
  EXPECT_NE(blind.output, "");
}

}  // namespace
}  // namespace infuse::daemon
