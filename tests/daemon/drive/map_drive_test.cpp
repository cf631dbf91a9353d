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
#include "tests/daemon/drive/simulated.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/daemon/schema.hpp"
#include "tests/folders.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

constexpr const char* kBlock = R"(
seed = 3
duration_s = 76
[world]
map = "altfeld.osm"
route = [100, 104, 112, 110, 115, 117, 119, 107, 104, 112, 114]
build_radius_m = 70
ground_resolution = 1.0
[vehicle]
speed = 10
[[lidar]]
name = "top"
model = "VLP-16"
position = [1.0, 0.0, 1.95]
rays_per_pulse = 1
)";

/// The drive and its map, made once; "replayed" is the map before its closures are sought.
struct Made {
  TemporaryFolder folder;
  std::string error;
  std::vector<geometry::StampedPose> truth;

  Made() {
    const auto drive = simulate(folder / "drive", kBlock);
    const auto poses = recording::read_trajectory(folder / "drive/truth/poses.tum");
    if (!drive || !poses) {
      error = "the drive cannot be made";
      return;
    }
    for (const auto& pose : *poses) truth.push_back({pose.stamp, pose.T_frame_body});
    auto setup = open_drive(folder / "drive", {}, {});
    if (!setup || !replay_to_map(MapFolder(map("replayed")), *setup, 0, {})) {
      error = "the drive cannot be replayed";
      return;
    }
    std::filesystem::copy(map("replayed"), map(), std::filesystem::copy_options::recursive);
    const ProgramResult run = infuse("map " + (folder / "drive").string() + " -o " + map());
    if (run.code != 0) error = run.output;
  }

  std::string map(const std::string& name = "map") const { return (folder / name).string(); }

  static ProgramResult infused(const std::string& arguments) {
    return run_shell_command(programs_folder() + "/infused " + arguments + " 2>&1");
  }
  static ProgramResult infuse(const std::string& arguments) {
    return run_shell_command(programs_folder() + "/infuse " + arguments + " 2>&1");
  }
};

class MapDrive : public testing::Test {
 protected:
  // Under a sanitizer the drive takes minutes, in each test's process.
#ifdef __SANITIZE_ADDRESS__
  static constexpr bool kTooSlow = true;
#else
  static constexpr bool kTooSlow = false;
#endif
  static void SetUpTestSuite() { made_ = kTooSlow ? nullptr : new Made; }
  static void TearDownTestSuite() { delete made_; }
  void SetUp() override {
    if (kTooSlow) GTEST_SKIP() << "too slow with the address sanitizer";
    ASSERT_EQ(made_->error, "");
  }

  static std::string copy(const std::string& name, const std::string& of = "map") {
    std::filesystem::copy(made_->map(of), made_->map(name),
                          std::filesystem::copy_options::recursive);
    return made_->map(name);
  }

  /// Names and bytes of all files of a folder.
  static std::map<std::string, std::string> bytes_of(const std::string& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      if (entry.is_regular_file()) {
        files[entry.path().lexically_relative(folder).string()] = read_file(entry.path());
      }
    }
    return files;
  }

  /// Root mean square error of the positions in a trajectory, m.
  static double error_of(const std::string& trajectory) {
    const auto poses = recording::read_trajectory(trajectory);
    EXPECT_TRUE(poses) << poses.error().message();
    std::vector<geometry::StampedPose> estimate;
    for (const auto& pose : *poses) estimate.push_back({pose.stamp, pose.T_frame_body});
    return motion::absolute_error(motion::pair_by_time(estimate, made_->truth)).translation.rms;
  }

  static Made* made_;
};

Made* MapDrive::made_ = nullptr;

TEST_F(MapDrive, ClosesTheLoopWhereTheTruthDoes) {
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
TEST_F(MapDrive, CorrectsOdometryThatDrifts) {
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

TEST_F(MapDrive, GivesTheSameBytesAfterKills) {
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

TEST_F(MapDrive, RefusesDamagedMapsAndNamesTheFile) {
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

TEST_F(MapDrive, ExportsWhatOtherCommandsRead) {
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

TEST_F(MapDrive, SaysWhatIsWrong) {
  const std::string drive = (made_->folder / "drive").string();
  EXPECT_THAT(Made::infuse("map " + drive + " --no-gnss -o " + made_->map()).output,
              HasSubstr("another drive, lidar or settings"));
  const std::string other = made_->map("other");
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

/// Another visit to the block: other cars stand and drive there.
std::string visit(const std::string& route, int seconds) {
  std::string scenario = kBlock;
  const auto replace = [&](const std::string& from, const std::string& to) {
    scenario.replace(scenario.find(from), from.size(), to);
  };
  replace("seed = 3", "seed = 8");
  replace("duration_s = 76", "duration_s = " + std::to_string(seconds));
  const std::string built = "[100, 104, 112, 110, 115, 117, 119, 107, 104, 112, 114]";
  replace("route = " + built, "seed = 3\nbuilt_along = " + built + "\nroute = " + route);
  return scenario;
}

/// Errors of poses on the map, m: relative to the nearest keyframe, as the truth of both visits has
/// it. What the map itself is wrong by does not count.
std::vector<double> errors_on_map(const std::vector<geometry::StampedPose>& on_map,
                                  const std::vector<geometry::StampedPose>& truth,
                                  const std::vector<geometry::StampedPose>& keyframes,
                                  const std::vector<geometry::StampedPose>& keyframe_truth) {
  const auto pairs = motion::pair_by_time(on_map, truth);
  const auto of_map = motion::pair_by_time(keyframes, keyframe_truth);
  std::vector<double> errors;
  for (const auto& pose : pairs) {
    const auto nearest =
        std::min_element(of_map.begin(), of_map.end(), [&](const auto& a, const auto& b) {
          const Eigen::Vector3d p = pose.estimate.translation();
          return (a.estimate.translation() - p).norm() < (b.estimate.translation() - p).norm();
        });
    errors.push_back(((nearest->truth.inverse() * pose.truth).translation() -
                      (nearest->estimate.inverse() * pose.estimate).translation())
                         .head<2>()
                         .norm());
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

std::vector<geometry::StampedPose> read_poses(const std::filesystem::path& file) {
  const auto poses = recording::read_trajectory(file);
  EXPECT_TRUE(poses) << poses.error().message();
  std::vector<geometry::StampedPose> out;
  for (const auto& pose : *poses) out.push_back({pose.stamp, pose.T_frame_body});
  return out;
}

// From nothing, against the direction in which the map was driven.
TEST_F(MapDrive, AnotherVisitIsFoundOnTheMapAndTracked) {
  const std::string other = (made_->folder / "other").string();
  ASSERT_TRUE(simulate(other, visit("[110, 112, 104, 100]", 20)));
  const std::string track = (made_->folder / "on_map.tum").string();
  const ProgramResult run =
      Made::infuse("map locate " + made_->map() + " " + other + " -o " + track + " --json");
  ASSERT_EQ(run.code, 0) << run.output;
  EXPECT_TRUE(is_result(run.output, "map-locate"));
  const auto summary = nlohmann::json::parse(run.output);
  EXPECT_LT(summary["found_after_s"], 10) << run.output;
  EXPECT_GT(summary["tracking"], 100) << run.output;
  const auto errors = errors_on_map(read_poses(track), read_poses(other + "/truth/poses.tum"),
                                    read_poses(made_->map() + "/trajectory.tum"), made_->truth);
  ASSERT_FALSE(errors.empty());
  EXPECT_LT(errors[errors.size() / 2], 0.1);
  EXPECT_LT(errors.back(), 0.4);

  // The daemon does the same, to the same bytes at any rate.
  const auto file = [&](const std::string& name) { return (made_->folder / name).string(); };
  write_file(file("infused.toml"), "[map]\ndirectory = \"map\"\n");
  for (const auto& [reports, rate] : {std::pair{"a.jsonl", ""}, {"b.jsonl", " --rate 8"}}) {
    const ProgramResult replay = Made::infused(
        "--replay " + other + " --config " + file("infused.toml") + " --socket " + file("s") +
        " --trajectory " + file("live.tum") + " --reports " + file(reports) + rate);
    ASSERT_EQ(replay.code, 0) << replay.output;
  }
  const std::string reports = read_file(file("a.jsonl"));
  EXPECT_EQ(reports, read_file(file("b.jsonl")));
  std::vector<geometry::StampedPose> on_map;
  std::istringstream lines(reports);
  for (std::string line; std::getline(lines, line);) {
    const auto report = nlohmann::json::parse(line);
    if (report["class"] != "POSE" || report["frame"] != "map" || !report["usable"]) continue;
    EXPECT_EQ(report["state"], "TRACKING");
    geometry::StampedPose pose;
    pose.stamp = Stamp::from_ns(report["stamp"].get<int64_t>());
    for (int i = 0; i < 12; ++i) {
      pose.T_odom_vehicle.matrix()(i / 4, i % 4) =
          report["T_frame_vehicle"][static_cast<size_t>(i)].get<double>();
    }
    on_map.push_back(pose);
  }
  EXPECT_GT(on_map.size(), 90U);
  EXPECT_EQ(read_poses(file("live.tum")).size(),
            on_map.size());  // the trajectory is in the map, too
  const auto live = errors_on_map(on_map, read_poses(other + "/truth/poses.tum"),
                                  read_poses(made_->map() + "/trajectory.tum"), made_->truth);
  ASSERT_FALSE(live.empty());
  EXPECT_LT(live[live.size() / 2], 0.1);
  EXPECT_LT(live.back(), 0.5);
}

// The other visit goes against the first one; its map has a frame of its own.
TEST_F(MapDrive, AnotherVisitIsMergedIntoTheMap) {
  const std::string other = (made_->folder / "tuesday").string();
  ASSERT_TRUE(simulate(other, visit("[117, 115, 110, 112, 104, 100]", 40)));
  ASSERT_EQ(Made::infuse("map " + other + " --no-gnss -o " + made_->map("of_tuesday")).code, 0);
  const std::string both = made_->map("both");
  const std::string command =
      "map merge " + made_->map() + " " + made_->map("of_tuesday") + " --no-gnss -o " + both;
  const ProgramResult run = Made::infuse(command + " --json");
  ASSERT_EQ(run.code, 0) << run.output;
  EXPECT_TRUE(is_result(run.output, "map"));
  const auto summary = nlohmann::json::parse(run.output);
  EXPECT_EQ(summary["drives"], 2);
  EXPECT_GT(summary["closures"], 20) << run.output;
  std::vector<motion::PosePair> pairs =
      motion::pair_by_time(read_poses(both + "/trajectory.tum"), made_->truth);
  const size_t of_first = pairs.size();
  for (const auto& pair : motion::pair_by_time(read_poses(both + "/trajectory_2.tum"),
                                               read_poses(other + "/truth/poses.tum"))) {
    pairs.push_back(pair);
  }
  EXPECT_GT(pairs.size(), of_first + 50);
  EXPECT_LT(motion::absolute_error(pairs).translation.rms, 0.3);

  // It goes on where it was interrupted, to the same bytes, and is a map as any other.
  const auto expected = bytes_of(both);
  for (const char* last : {"map.json", "drive.json"}) {
    std::filesystem::remove(both + "/" + last);
    EXPECT_EQ(Made::infuse(command).code, 0);
    EXPECT_TRUE(bytes_of(both) == expected) << last;
  }
  const std::string tum = (made_->folder / "second.tum").string();
  EXPECT_EQ(Made::infuse("map export " + both + " --drive 2 -o " + tum).code, 0);
  EXPECT_EQ(read_file(tum), read_file(both + "/trajectory_2.tum"));
  EXPECT_THAT(Made::infuse("map export " + both + " --drive 3 -o " + tum).output,
              HasSubstr("there is no drive 3"));
  EXPECT_THAT(Made::infuse("map merge " + both + " " + made_->map() + " -o " + both).output,
              HasSubstr("merged into itself"));
  EXPECT_EQ(Made::infuse("map merge " + both + " -o " + made_->map("alone")).code, 2);
}

// A map of two drives along one street, of which the slower one has taken over all clouds.
TEST_F(MapDrive, AMapWhoseDriveHasNoCloudsIsMergedInEitherOrder) {
  const std::string route = "[117, 115, 110, 112, 104, 100]";
  std::vector<geometry::StampedPose> truth[2];
  for (const int i : {0, 1}) {
    std::string scenario = visit(route, i == 0 ? 22 : 30);
    if (i == 1) {
      scenario.replace(scenario.find("seed = 8"), 8, "seed = 9");
      scenario.replace(scenario.find("speed = 10"), 10, "speed = 8");
    }
    const std::string name = "lap" + std::to_string(i);
    const std::string drive = (made_->folder / name).string();
    ASSERT_TRUE(simulate(drive, scenario));
    ASSERT_EQ(Made::infuse("map " + drive + " --no-gnss -o " + made_->map("of_" + name)).code, 0);
    truth[i] = read_poses(drive + "/truth/poses.tum");
  }
  const auto merge = [](const std::string& a, const std::string& b, const std::string& target) {
    return Made::infuse("map merge " + made_->map(a) + " " + made_->map(b) + " --no-gnss -o " +
                        made_->map(target));
  };
  ProgramResult run = merge("of_lap0", "of_lap1", "laps");
  ASSERT_EQ(run.code, 0) << run.output;
  const auto laps = read_map(MapFolder(made_->map("laps")));
  ASSERT_TRUE(laps) << laps.error().message();
  const auto& of_laps = laps->drive.keyframes;
  EXPECT_LT(std::count_if(of_laps.begin(),
                          of_laps.begin() + static_cast<ptrdiff_t>(laps->drive.first_keyframes[1]),
                          [](const auto& keyframe) { return keyframe.keyframe.has_cloud; }),
            3)
      << "else nothing is shown";

  for (const bool last : {true, false}) {
    const std::string target = last ? "laps_last" : "laps_first";
    run = last ? merge("map", "laps", target) : merge("laps", "map", target);
    ASSERT_EQ(run.code, 0) << run.output;
    const std::string both = made_->map(target);
    const size_t first_lap = last ? 1 : 0;
    std::vector<motion::PosePair> pairs;
    size_t of_drive[3];
    for (size_t d = 0; d < 3; ++d) {
      const bool is_lap = d >= first_lap && d < first_lap + 2;
      const auto part = motion::pair_by_time(read_poses(both + "/" + MapFolder::trajectory_name(d)),
                                             is_lap ? truth[d - first_lap] : made_->truth);
      of_drive[d] = part.size();
      pairs.insert(pairs.end(), part.begin(), part.end());
    }
    EXPECT_GT(std::min({of_drive[0], of_drive[1], of_drive[2]}), 50U);
    EXPECT_LT(motion::absolute_error(pairs).translation.rms, 0.3);
    // All along the street, not where they join alone.
    const auto map = read_map_drive(MapFolder(both));
    ASSERT_TRUE(map);
    const size_t border = map->first_keyframes[last ? 1 : 2];
    const auto closures = parse_closures(read_file(both + "/closures.csv"), "closures.csv");
    ASSERT_TRUE(closures);
    EXPECT_GT(std::count_if(closures->begin(), closures->end(),
                            [&](const auto& closure) {
                              return closure.accepted() && closure.from < border &&
                                     closure.to >= border;
                            }),
              20);
  }
  // And what came of it once more.
  run = merge("laps_last", "of_lap0", "again");
  EXPECT_EQ(run.code, 0) << run.output;
}

TEST_F(MapDrive, AMapThatIsNotUsableKeepsItsClouds) {
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

TEST_F(MapDrive, MapsWithoutACommonStreetAreNotMerged) {
  const std::string other = (made_->folder / "another_town").string();
  std::string scenario = visit("[100, 104]", 16);
  const size_t begin = scenario.find("map ="), end = scenario.find("build_radius_m");
  scenario.replace(begin, end - begin, "town_size_m = 500\nroute_length_m = 300\n");
  ASSERT_TRUE(simulate(other, scenario));
  ASSERT_EQ(Made::infuse("map " + other + " -o " + made_->map("of_another")).code, 0);
  const ProgramResult run = Made::infuse("map merge " + made_->map() + " " +
                                         made_->map("of_another") + " -o " + made_->map("neither"));
  EXPECT_EQ(run.code, 3);
  EXPECT_THAT(run.output, HasSubstr("drive 2 cannot be joined"));
  EXPECT_FALSE(std::filesystem::exists(made_->map("neither") + "/map.json"));
}

TEST_F(MapDrive, ADriveElsewhereIsNotFoundOnTheMap) {
  const std::string other = (made_->folder / "elsewhere").string();
  std::string scenario = visit("[100, 104]", 12);
  const size_t begin = scenario.find("map ="), end = scenario.find("build_radius_m");
  scenario.replace(begin, end - begin, "town_size_m = 500\nroute_length_m = 300\n");
  ASSERT_TRUE(simulate(other, scenario));
  const ProgramResult run = Made::infuse("map locate " + made_->map() + " " + other);
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.output, HasSubstr("not found on the map"));
}

}  // namespace
}  // namespace infuse::daemon
