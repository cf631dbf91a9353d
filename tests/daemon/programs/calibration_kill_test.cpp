// What `infuse apply` and `infuse rollback` were answered is what a restarted daemon uses, whenever
// it is killed. INFUSE_KILLS=50 in the environment: as many moments; by default six.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <thread>

#include "daemon/calibration/saved_calibrations.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/daemon/socket_client.hpp"
#include "tests/folders.hpp"

namespace infuse::daemon {
namespace {

/// infused with a lidar and a camera that are not there.
class KilledDaemon : public testing::Test {
 protected:
  KilledDaemon() {
    std::filesystem::create_directories(state());
    std::ofstream(folder_ / "rig.toml")
        << "[[lidar]]\nname = \"top\"\nT_vehicle_lidar = [1,0,0,0, 0,1,0,0, 0,0,1,2, 0,0,0,1]\n"
           "[[camera]]\nname = \"front\"\nlidar = \"top\"\nwidth = 640\nheight = 480\nfx = 500\n"
           "fy = 500\ncx = 320\ncy = 240\nT_camera_lidar = [0,-1,0,0, 0,0,-1,0, 1,0,0,0, "
           "0,0,0,1]\n";
    std::ofstream(folder_ / "infused.toml")
        << "log_level = \"off\"\nrig = \"rig.toml\"\n[[lidar]]\nname = \"top\"\n"
           "model = \"VLP-16\"\nport = "
        << 20'000 + ::getpid() % 20'000
        << "\n[[camera]]\nname = \"front\"\ndevice = \"/dev/infuse-no-camera\"\n";
  }
  ~KilledDaemon() override { kill(); }

  std::filesystem::path state() const { return folder_ / "state"; }
  std::filesystem::path socket() const { return folder_ / "s"; }

  void start() {
    const std::string program = programs_folder() + "/infused", file = folder_ / "infused.toml",
                      path = socket(), folder = state();
    process_ = ::fork();
    if (process_ == 0) {
      ::setenv("STATE_DIRECTORY", folder.c_str(), 1);
      ::execl(program.c_str(), "infused", "--config", file.c_str(), "--socket", path.c_str(),
              nullptr);
      ::_exit(127);
    }
    for (int i = 0; i < 1000 && !SocketClient(socket()).connected(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }

  void kill() {
    if (process_ <= 0) return;
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
    process_ = 0;
  }

  /// Position of the camera that the next run will use: of the file, or the configured one.
  double saved_x() const {
    std::stringstream text;
    text << std::ifstream(state() / kCalibrationsFile).rdbuf();
    if (text.str().empty()) return 0;
    auto saved = parse_calibrations(text.str());
    if (!saved) return -1;
    const CameraCalibrations& camera = *saved->find("front");
    return camera.find(camera.in_use)->T_camera_lidar.translation().x();
  }

  TemporaryFolder folder_;
  pid_t process_ = 0;
};

std::string request_to_apply(double x) {
  const nlohmann::json request = {
      {"op", "apply"},
      {"device", "front"},
      {"T_camera_lidar", {0, -1, 0, x, 0, 0, -1, 0, 1, 0, 0, 0, 0, 0, 0, 1}}};
  return request.dump() + "\n";
}

TEST_F(KilledDaemon, UsesWhatItAnswered) {
  const char* asked = std::getenv("INFUSE_KILLS");
  const int kills = asked != nullptr ? std::atoi(asked) : 6;
  std::mt19937 random(1);
  double in_use = 0, before = 0;
  int answered = 0;
  for (int k = 1; k <= kills; ++k) {
    start();
    SocketClient owner(socket());
    ASSERT_TRUE(owner.read_line());  // the greeting
    const bool back = k > 2 && k % 3 == 0;
    const double next = back ? before : 0.01 * k;
    owner.send(back ? "{\"op\":\"rollback\"}\n" : request_to_apply(next));
    // Odd ones are killed as soon as they answer, even ones some time before or after that.
    const int wait_ms = k % 2 == 1 ? 10'000 : static_cast<int>(random() % 4);
    const auto answer = owner.read_line(wait_ms);
    kill();
    const double x = saved_x();
    if (answer) {
      ++answered;
      ASSERT_NE(answer->find("\"ACK\""), std::string::npos) << *answer;
      EXPECT_EQ(x, next) << k;
    } else {
      EXPECT_TRUE(x == next || x == in_use) << k << ": " << x;
    }
    if (x != in_use) before = std::exchange(in_use, x);
  }
  EXPECT_GE(answered, kills / 2);
  start();
  SocketClient owner(socket());
  ASSERT_TRUE(owner.read_line());
  owner.send("{\"op\":\"watch\",\"classes\":[\"CALIBRATION\"]}\n");
  ASSERT_TRUE(owner.read_line());
  const auto report = owner.read_line();
  ASSERT_TRUE(report);
  EXPECT_EQ(nlohmann::json::parse(*report)["T_camera_lidar"][3], in_use);
}

}  // namespace
}  // namespace infuse::daemon
