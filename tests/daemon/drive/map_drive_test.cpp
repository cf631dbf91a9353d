// A map of a simulated drive around a block, against the simulator's truth.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "daemon/mapping/map_finish.hpp"
#include "daemon/mapping/place_map.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "daemon/tools/map/map_drive.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "fusion/motion/trajectory_error.hpp"
#include "tests/daemon/drive/block_map.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/daemon/schema.hpp"
#include "tests/folders.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

TEST_F(BlockMap, ClosesTheLoopWhereTheTruthDoes) {
  EXPECT_LT(error_of(made_->map() + "/trajectory.tum"), 0.2);
  const auto drive = read_map_drive(MapFolder(made_->map()));
  ASSERT_TRUE(drive) << drive.error().message();
  const auto closures = parse_closures(read_file(made_->map() + "/closures.csv"), "closures.csv");
  ASSERT_TRUE(closures) << closures.error().message();
  size_t accepted = 0;
  for (const mapping::Closure& closure : *closures) {
    if (!closure.accepted()) continue;
    ++accepted;
    std::vector<geometry::StampedPose> pair(2);
    pair[0].stamp = drive->keyframes[closure.from].keyframe.stamp;
    pair[1].stamp = drive->keyframes[closure.to].keyframe.stamp;
    const auto at = motion::pair_by_time(pair, made_->truth);
    ASSERT_EQ(at.size(), 2U);
    const Eigen::Isometry3d error =
        (at[0].truth.inverse() * at[1].truth).inverse() * closure.T_from_to;
    EXPECT_LT(error.translation().norm(), 0.15) << closure.from << ", " << closure.to;
    EXPECT_LT(std::abs(geometry::log(error)[2]), 0.002);
    EXPECT_LT(Eigen::AngleAxisd(error.linear()).angle(), 0.015);  // sixteen rings hardly see pitch
  }
  EXPECT_GE(accepted, 2U);
}

// Odometry whose heading drifts by 1.2 degrees over the block: closures bring it back.
TEST_F(BlockMap, CorrectsOdometryThatDrifts) {
  const MapFolder replayed(made_->map("replayed"));
  auto drive = read_map_drive(replayed);
  ASSERT_TRUE(drive);
  const std::vector<MapKeyframe> true_to_file = drive->keyframes;
  for (size_t k = 1; k < true_to_file.size(); ++k) {
    const Eigen::Isometry3d step = true_to_file[k - 1].keyframe.T_odom_vehicle.inverse() *
                                   true_to_file[k].keyframe.T_odom_vehicle;
    drive->keyframes[k].keyframe.T_odom_vehicle =
        drive->keyframes[k - 1].keyframe.T_odom_vehicle * step *
        Eigen::AngleAxisd(1.2e-4, Eigen::Vector3d::UnitZ());
  }
  const auto error = [&](bool close_loops) {
    const MapFolder folder(copy(close_loops ? "closed" : "drifting", "replayed"));
    const auto made = finish_map(folder, *drive, {.close_loops = close_loops, .use_gnss = false},
                                 [](size_t, size_t, size_t) {});
    EXPECT_TRUE(made) << made.error().message();
    return error_of(folder.path_of(MapFolder::trajectory_name(0)));
  };
  const double before = error(false), after = error(true);
  EXPECT_GT(before, 0.5) << "else nothing is shown";
  EXPECT_LT(after, before / 2);
}

TEST_F(BlockMap, GivesTheSameBytesAfterKills) {
  const std::string map = made_->map("killed");
  const std::string command = "map " + (made_->folder / "drive").string() + " -o " + map;
  for (const char* seconds : {"0.3", "1.1", "2.3"}) {
    run_shell_command(std::string("timeout -s KILL ") + seconds + " " + programs_folder() +
                      "/infuse " + command + " 2>&1");
  }
  EXPECT_EQ(Made::infuse(command).code, 0);
  const auto expected = bytes_of(made_->map());
  EXPECT_TRUE(bytes_of(map) == expected);
  // As after a kill between two closures, and before each of the last files.
  const std::string between = copy("between", "replayed");
  const std::string closures = expected.at("closures.csv");
  const size_t second_row = closures.find('\n', closures.find('\n') + 1) + 1;
  ASSERT_LT(second_row, closures.size());
  write_file(between + "/closures.csv", closures.substr(0, second_row));
  write_file(between + "/clouds/000007.pcd.zst.q1w2e3", "half a file");
  const std::string go_on = "map " + (made_->folder / "drive").string() + " -o " + between;
  for (const char* last : {"map.json", "trajectory.tum", "graph.g2o"}) {
    std::filesystem::remove(between + "/" + last);
    EXPECT_EQ(Made::infuse(go_on).code, 0);
    EXPECT_TRUE(bytes_of(between) == expected) << last;
  }
}

TEST_F(BlockMap, RefusesDamagedMapsAndNamesTheFile) {
  const std::string out = (made_->folder / "out").string();
  const auto flip = [](const std::string& file) {
    std::string bytes = read_file(file);
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
    write_file(file, bytes);
  };
  int index = 0;
  const auto drive = read_map_drive(MapFolder(made_->map()));
  ASSERT_TRUE(drive);
  const std::string cloud = MapFolder::cloud_name(drive->keyframes.size() - 1);
  for (const std::string& name : {cloud, std::string("keyframes.csv"), std::string("fixes.csv"),
                                  std::string("drive.json"), std::string("graph.g2o")}) {
    const std::string map = copy("damaged" + std::to_string(index++));
    flip(map + "/" + name);
    std::string command = "map export " + map + " -o ";
    command += out + ".pcd";
    const ProgramResult refused = Made::infuse(command);
    EXPECT_EQ(refused.code, 3) << name;
    EXPECT_THAT(refused.output, HasSubstr(name));
    std::filesystem::remove(map + "/" + name);
    EXPECT_EQ(Made::infuse(command).code, 3) << name;
  }
  const std::string cut = copy("cut");
  write_file(cut + "/map.json", read_file(cut + "/map.json").substr(0, 300));
  EXPECT_THAT(Made::infuse("map export " + cut + " -o " + out + ".pcd").output,
              HasSubstr("map.json"));
  std::filesystem::remove(cut + "/map.json");
  EXPECT_THAT(Made::infuse("map export " + cut + " -o " + out + ".pcd").output,
              HasSubstr("the map is not complete"));
  EXPECT_FALSE(std::filesystem::exists(out + ".pcd"));
}

TEST_F(BlockMap, ExportsWhatOtherCommandsRead) {
  const auto file = [&](const char* name) { return (made_->folder / name).string(); };
  for (const char* name : {"m.pcd", "m.ply", "m.png", "m.tum", "m.tif"}) {
    const ProgramResult made = Made::infuse("map export " + made_->map() + " -o " + file(name));
    EXPECT_EQ(made.code, 0) << made.output;
  }
  EXPECT_EQ(read_file(file("m.tum")), read_file(made_->map() + "/trajectory.tum"));
  EXPECT_EQ(read_file(file("m.png")).substr(1, 3), "PNG");
  EXPECT_EQ(read_file(file("m.tif")).substr(0, 3), "II*");
  const std::string pcd = read_file(file("m.pcd")), ply = read_file(file("m.ply"));
  EXPECT_EQ(pcd.substr(pcd.find("DATA binary\n") + 12), ply.substr(ply.find("end_header\n") + 11));
  EXPECT_GT(pcd.size(), 1'000'000U);
  EXPECT_EQ(Made::infuse("map export " + made_->map() + " -o " + file("m.stl")).code, 2);
  const ProgramResult no_points =
      Made::infuse("map export " + made_->map() + " --without-moving -o " + file("n.tum"));
  EXPECT_EQ(no_points.code, 2);
  EXPECT_THAT(no_points.output, HasSubstr("does not apply to a trajectory"));
}

TEST_F(BlockMap, SaysWhatIsWrong) {
  const std::string drive = (made_->folder / "drive").string();
  EXPECT_THAT(Made::infuse("map " + drive + " --no-gnss -o " + made_->map()).output,
              HasSubstr("another drive, lidar or settings"));
  const std::string other = made_->map("letters");
  std::filesystem::create_directories(other);
  write_file(other + "/letter.txt", "dear");
  EXPECT_THAT(Made::infuse("map " + drive + " -o " + other).output, HasSubstr("letter.txt"));
  EXPECT_EQ(Made::infuse("map " + drive).code, 2);
  EXPECT_EQ(Made::infuse("map").code, 2);
  EXPECT_EQ(Made::infuse("map " + drive + "/nothing -o " + other).code, 3);
  // A drive without a lidar.
  const std::string without = (made_->folder / "without").string();
  std::filesystem::create_directories(without);
  write_file(without + "/drive.toml", "name = \"no lidar\"\n");
  const ProgramResult none = Made::infuse("map " + without + " -o " + made_->map("none"));
  EXPECT_NE(none.code, 0);
  EXPECT_THAT(none.output, HasSubstr("there is no lidar"));
}

TEST_F(BlockMap, AMapThatIsNotUsableKeepsItsClouds) {
  const MapFolder folder(copy("not_usable", "replayed"));
  auto drive = read_map_drive(folder);
  ASSERT_TRUE(drive);
  drive->manifest["unmeasured"] = drive->manifest["sweeps"];
  const auto made = finish_map(folder, *drive, {.close_loops = false}, {});
  ASSERT_TRUE(made) << made.error().message();
  EXPECT_FALSE(made->usable());
  EXPECT_EQ(made->clouds, drive->keyframes.size());
  EXPECT_EQ(bytes_of(folder.path_of("clouds")), bytes_of(made_->map("replayed") + "/clouds"));
  const auto map = open_place_map(folder);
  ASSERT_TRUE(map) << map.error().message();
  EXPECT_EQ(map->descriptors.size(), drive->keyframes.size());
}

}  // namespace
}  // namespace infuse::daemon
