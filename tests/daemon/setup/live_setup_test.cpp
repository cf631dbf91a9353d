#include "daemon/setup/live_setup.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <regex>

#include "drivers/text/text_file.hpp"
#include "tests/folders.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

constexpr const char* kRig = R"(
[[lidar]]
name = "top"
T_vehicle_lidar = [1,0,0,1.5, 0,1,0,0, 0,0,1,1.8, 0,0,0,1]
[[camera]]
name = "front"
lidar = "top"
width = 640
height = 480
fx = 500
fy = 500
cx = 320
cy = 240
stamp_delay_ms = 4
T_camera_lidar = [0,-1,0,0, 0,0,-1,0, 1,0,0,0, 0,0,0,1]
)";

/// A configuration folder with rig.toml and a DBC file.
class LiveSetupTest : public testing::Test {
 protected:
  LiveSetupTest() {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "rig.toml") << kRig;
    std::ofstream(folder_ / "car.dbc") << "BO_ 291 ESP: 8 X\n SG_ YAW : 0|16@1- (0.1,0) [0|0] "
                                          "\"deg/s\" X\n";
  }
  ~LiveSetupTest() override { std::filesystem::remove_all(folder_); }

  Result<SensorSetup> set_up(const std::string& text) {
    auto config = parse_config(text, "x.toml");
    EXPECT_TRUE(config.has_value()) << config.error().message();
    config->folder = folder_;
    return set_up_live(*config);
  }

  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("infuse-live-" + std::to_string(getpid()));
};

TEST_F(LiveSetupTest, SensorsAreMountedAsTheRigHasThem) {
  const auto setup = set_up(
      "rig = \"rig.toml\"\n"
      "[[camera]]\nname = \"rear\"\ndevice = \"/dev/video1\"\n"
      "[[camera]]\nname = \"front\"\ndevice = \"/dev/video0\"\n"
      "[[lidar]]\nname = \"top\"\nmodel = \"VLP-16\"\n"
      "[[can]]\nname = \"bus\"\ndbc = \"car.dbc\"\nsignals = { yaw_rate = \"ESP.YAW\" }\n"
      "[gnss]\ndevice = \"/dev/ttyUSB0\"\n");
  ASSERT_TRUE(setup.has_value()) << setup.error().message();
  EXPECT_TRUE(setup->live);
  ASSERT_EQ(setup->rig.lidars.size(), 1U);
  EXPECT_EQ(setup->rig.lidars[0].T_vehicle_lidar.translation().z(), 1.8);
  // The camera of the rig comes first, with the size and delay of the rig.
  ASSERT_EQ(setup->rig.cameras.size(), 1U);
  ASSERT_EQ(setup->cameras.size(), 2U);
  EXPECT_EQ(setup->cameras[0].stream.device, "/dev/video0");
  EXPECT_EQ(setup->cameras[0].stream.width, 640);
  EXPECT_EQ(setup->cameras[0].stream.stamp_delay, from_seconds(0.004));
  std::vector<std::string> kinds;
  for (const auto& [id, device] : setup->sensors())
    kinds.push_back(device.kind + " " + device.name);
  EXPECT_THAT(kinds, testing::ElementsAre("lidar top", "camera front", "camera rear", "can bus",
                                          "gnss gnss"));
  EXPECT_EQ(setup->sensors()[2].id, (SensorId{SensorKind::kCamera, 1}));
  EXPECT_FALSE(setup->is_mounted(CameraIndex(1)));
  // The kernel passes only the identifiers that the signals need.
  ASSERT_EQ(setup->vehicle.buses.size(), 1U);
  EXPECT_EQ(setup->vehicle.buses[0].interface.identifiers,
            (std::vector<vehicle::CanIdentifier>{{291, false}}));
  EXPECT_TRUE(setup->vehicle.has_odometry());
}

TEST_F(LiveSetupTest, AGnssReceiverMayBeConnectedToALidar) {
  const std::string lidars =
      "[[lidar]]\nname = \"a\"\nmodel = \"VLP-16\"\nsender = \"10.0.0.1\"\n"
      "[[lidar]]\nname = \"b\"\nmodel = \"VLP-16\"\nsender = \"10.0.0.2\"\n";
  const auto setup = set_up(lidars + "[gnss]\nlidar = \"b\"\n");
  ASSERT_TRUE(setup.has_value()) << setup.error().message();
  EXPECT_EQ(setup->gnss_lidar, 1U);
  EXPECT_FALSE(setup->gnss_serial.has_value());
  EXPECT_EQ(setup->sensors().back().id.kind, SensorKind::kGnss);
  EXPECT_FALSE(set_up(lidars + "[gnss]\nlidar = \"c\"\n").has_value());
}

TEST_F(LiveSetupTest, LidarsThatShareAPortAreDistinguishedBySender) {
  const auto setup = set_up(
      "[[lidar]]\nname = \"a\"\nmodel = \"VLP-16\"\nsender = \"10.0.0.1\"\n"
      "[[lidar]]\nname = \"b\"\nmodel = \"VLP-16\"\nsender = \"10.0.0.2\"\n"
      "[[lidar]]\nname = \"c\"\nmodel = \"VLP-16\"\nport = 2369\nposition_port = 8309\n");
  ASSERT_TRUE(setup.has_value());
  ASSERT_EQ(setup->ports.size(), 4U);  // 2368, 8308, 2369, 8309
  EXPECT_EQ(setup->ports[0].lidar_of(0x0A000001), 0U);
  EXPECT_EQ(setup->ports[0].lidar_of(0x0A000002), 1U);
  EXPECT_EQ(setup->ports[0].lidar_of(0x0A000003), 0U);  // rejects and counts it
  EXPECT_EQ(setup->ports[2].lidar_of(0x0A000003), 2U);
}

TEST_F(LiveSetupTest, TheExamplesAreValid) {
  std::ofstream(folder_ / "all.dbc") << "BO_ 1 WHEEL_SPEEDS: 8 X\n"
                                        " SG_ REAR_LEFT : 0|16@1+ (0.01,0) [0|0] \"m/s\" X\n"
                                        " SG_ REAR_RIGHT : 16|16@1+ (0.01,0) [0|0] \"m/s\" X\n"
                                        "BO_ 2 ESP: 8 X\n"
                                        " SG_ YAW_RATE : 0|16@1- (0.1,0) [0|0] \"deg/s\" X\n"
                                        "BO_ 3 GYRO: 8 X\n"
                                        " SG_ X : 0|16@1- (0.1,0) [0|0] \"deg/s\" X\n"
                                        " SG_ Y : 16|16@1- (0.1,0) [0|0] \"deg/s\" X\n"
                                        " SG_ Z : 32|16@1- (0.1,0) [0|0] \"deg/s\" X\n"
                                        "BO_ 4 ACC: 8 X\n"
                                        " SG_ X : 0|16@1- (0.1,0) [0|0] \"m/s^2\" X\n"
                                        " SG_ Y : 16|16@1- (0.1,0) [0|0] \"m/s^2\" X\n"
                                        " SG_ Z : 32|16@1- (0.1,0) [0|0] \"m/s^2\" X\n";
  std::filesystem::copy_file(std::filesystem::path(source_folder()) / "packaging/examples/rig.toml",
                             folder_ / "rig.toml",
                             std::filesystem::copy_options::overwrite_existing);
  const std::pair<const char*, size_t> examples[] = {
      {"infused.toml", 0}, {"shuttle.toml", 3}, {"survey_car.toml", 6}, {"truck.toml", 5}};
  for (const auto& [name, devices] : examples) {
    SCOPED_TRACE(name);
    const auto text = text::read_text(
        std::filesystem::path(source_folder()) / "packaging/examples" / name, 1 << 20);
    ASSERT_TRUE(text.has_value());
    const auto setup =
        set_up(std::regex_replace(*text, std::regex("/etc/infuse/\\w+.dbc"), "all.dbc"));
    ASSERT_TRUE(setup.has_value()) << setup.error().message();
    EXPECT_EQ(setup->sensors().size(), devices);
    EXPECT_TRUE(setup->vehicle.notes.empty());
  }
}

TEST_F(LiveSetupTest, NamesWhatIsValidButHardlyMeant) {
  const auto doubts = [&](const char* text) {
    const auto setup = set_up(text);
    EXPECT_TRUE(setup.has_value()) << setup.error().message();
    std::string all;
    if (setup) {
      for (const Error& doubt : setup->doubts) all += doubt.message() + "\n";
    }
    return all;
  };
  EXPECT_EQ(doubts("[[lidar]]\nname = \"a\"\nmodel = \"VLP-16\"\n"), "");
  EXPECT_THAT(doubts("[[camera]]\nname = \"frnt\"\ndevice = \"/dev/video0\"\n"),
              HasSubstr("camera 'frnt' is not in the rig"));
  EXPECT_THAT(doubts("rig = \"rig.toml\"\n[[lidar]]\nname = \"b\"\nmodel = \"VLP-16\"\n"),
              HasSubstr("lidar 'b' is not in the rig"));
  EXPECT_THAT(doubts("[health]\nexpected_sensors = [\"rear\"]\n"),
              HasSubstr("x.toml:1: expected_sensors names 'rear'"));
  EXPECT_THAT(doubts("[[can]]\n"), HasSubstr("has no signals"));
  EXPECT_EQ(doubts("[streetmap]\nmap = \"town.map\"\n"), "");  // all streets are searched
  EXPECT_THAT(doubts("[streetmap]\nmap = \"town.map\"\nglobal_start = false\n"),
              HasSubstr("initial pose on the street map"));
  EXPECT_EQ(doubts("[gnss]\ndevice = \"/dev/ttyUSB0\"\n[streetmap]\nmap = \"town.map\"\n"), "");
}

/// A lidar of the rig, and its camera.
constexpr const char* kMounted =
    "rig = \"rig.toml\"\n[[lidar]]\nname = \"top\"\nmodel = \"VLP-16\"\n"
    "[[camera]]\nname = \"front\"\n";

TEST_F(LiveSetupTest, RefusesARigThatNoVehicleHas) {
  const std::tuple<const char*, const char*, const char*> cases[] = {
      {"fx = 500", "fx = 1e9", "rig.toml:5: fx = 1e+09 pixels lets the camera see"},
      {"fx = 500", "fx = 5000", "fx is 10 times fy"},
      {"cx = 320", "cx = 3200", "lies outside the image"},
      {"cy = 240", "cy = 240\ndistortion = [-0.9, 0, 0, 0, 0]", "folds the image"},
      {"0,0,1,1.8", "0,0,1,1800", "rig.toml:2: T_vehicle_lidar moves by 1800 m"},
      {"[0,-1,0,0, 0,0,-1,0, 1,0,0,0, 0,0,0,1]", "[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]",
       "the identity"},
      {"name = \"front\"", "name = \"fr\\nont\"", "no control characters"}};
  for (const auto& [from, to, expected] : cases) {
    std::string rig = kRig;
    rig.replace(rig.find(from), std::string(from).size(), to);
    std::ofstream(folder_ / "rig.toml") << rig;
    const auto setup = set_up(kMounted);
    ASSERT_FALSE(setup.has_value()) << to;
    EXPECT_THAT(setup.error().message(), HasSubstr(expected));
  }
}

TEST_F(LiveSetupTest, AcceptsDistortionsOfRealCameras) {
  // KITTI's camera 2 of 2011-09-26, unrectified; a fisheye lens of 185° (Kannala-Brandt).
  for (const char* numbers :
       {"width = 1392\nheight = 512\nfx = 959.8\nfy = 952.9\ncx = 696\ncy = 224.2\n"
        "distortion = [-0.3691481, 0.1968681, 0.001353473, 0.0005677587, -0.06770705]",
        "model = \"fisheye\"\nwidth = 1280\nheight = 800\nfx = 330\nfy = 330\ncx = 640\n"
        "cy = 400\ndistortion = [0.05, -0.01, 0.003, -0.001]"}) {
    std::string rig = kRig;
    const size_t begin = rig.find("width"), end = rig.find("stamp_delay_ms");
    rig.replace(begin, end - begin, std::string(numbers) + "\n");
    std::ofstream(folder_ / "rig.toml") << rig;
    const auto setup = set_up(kMounted);
    EXPECT_TRUE(setup.has_value()) << setup.error().message();
  }
}

TEST_F(LiveSetupTest, RefusesWhatTheDaemonCannotOpen) {
  const std::pair<const char*, const char*> cases[] = {
      {"[metrics]\nport = 9469\n[view]\nport = 9469\n",
       "x.toml:3: [metrics] port and [view] port are both 9469"},
      {"[socket]\ntcp_port = 9469\n[metrics]\nport = 9469\n", "are both 9469"},
      {"[socket]\npath = \"/etc/passwd/s\"\n", "x.toml:1: a socket cannot be created"},
      {"[mqtt]\nhost = \"10.0.0.1\"\nvehicle = \"a\"\nca_file = \"none.pem\"\n", "ca_file"},
      {"[mqtt]\nhost = \"10.0.0.1\"\nvehicle = \"a\"\nca_file = \"/dev/zero\"\n",
       "is not a regular file"},
      {"[[camera]]\nname = \"a\"\ndevice = \"/dev/video0\"\n"
       "[[camera]]\nname = \"b\"\ndevice = \"/dev/video0\"\n",
       "x.toml:4: cameras 'a' and 'b' are both /dev/video0"},
      {"[[can]]\nname = \"a\"\n[[can]]\nname = \"b\"\n", "are both can0"},
      {"[odometry]\nuse_lidar = true\n", "x.toml:1: use_lidar needs a lidar"}};
  for (const auto& [text, expected] : cases) {
    const auto setup = set_up(text);
    ASSERT_FALSE(setup.has_value()) << text;
    EXPECT_THAT(setup.error().message(), HasSubstr(expected));
  }
}

TEST_F(LiveSetupTest, ReportsInvalidConfigurations) {
  const std::pair<const char*, const char*> cases[] = {
      {"[[lidar]]\n", "has no model"},
      {"\n[[lidar]]\n", ".toml:2: "},
      {"[[lidar]]\nname = \"top\"\nmodel = \"OS1-64\"\n",
       ".toml:1: lidar 'top': the sensor's metadata is missing (store what it gives"},
      {"[[lidar]]\nname = \"a\"\nmodel = \"VLP-16\"\n[[lidar]]\nname = \"b\"\nmodel = \"VLP-16\"\n",
       "cannot be told apart on port 2368"},
      {"[record]\ndirectory = \"rig.toml\"\n", "is not a folder"},
      {"rig = \"none.toml\"\n", "none.toml"},
      {"rig = \"rig.toml\"\n[[camera]]\nname = \"front\"\n", "not configured"},
      {"rig = \"rig.toml\"\n[[lidar]]\nname = \"top\"\nmodel = \"VLP-16\"\n"
       "[[camera]]\nname = \"front\"\nwidth = 320\nheight = 240\n",
       "the rig states 640x480"},
      {"[[can]]\ndbc = \"none.dbc\"\nsignals = { yaw_rate = \"ESP.YAW\" }\n", "none.dbc"},
      {"[[can]]\ndbc = \"car.dbc\"\nsignals = { yaw_rate = \"ESP.NONE\" }\n", "ESP.NONE"}};
  for (const auto& [text, expected] : cases) {
    const auto setup = set_up(text);
    ASSERT_FALSE(setup.has_value()) << text;
    EXPECT_THAT(setup.error().message(), HasSubstr(expected));
  }
}

}  // namespace
}  // namespace infuse::daemon
