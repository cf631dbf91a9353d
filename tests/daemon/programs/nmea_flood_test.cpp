// A serial line that brings far more sentences than any receiver sends.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <termios.h>

#include <atomic>
#include <nlohmann/json.hpp>

#include "drivers/host/file_descriptor.hpp"
#include "tests/daemon/live_daemon.hpp"
#include "tests/daemon/socket_client.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

/// Writes sentences to a pseudo-terminal as fast as they are taken.
class Flood {
 public:
  Flood() {
    EXPECT_EQ(grantpt(line_.get()), 0);
    EXPECT_EQ(unlockpt(line_.get()), 0);
    std::array<char, 64> name{};
    EXPECT_EQ(ptsname_r(line_.get(), name.data(), name.size()), 0);
    device_ = name.data();
    termios raw{};
    tcgetattr(line_.get(), &raw);
    cfmakeraw(&raw);
    tcsetattr(line_.get(), TCSANOW, &raw);
  }
  ~Flood() { stop(); }
  Flood(const Flood&) = delete;
  Flood& operator=(const Flood&) = delete;

  const std::string& device() const { return device_; }
  void start() {
    thread_ = std::thread([this] {
      // The sentence of NMEA 0183's own example, a whole buffer of them.
      std::string text;
      while (text.size() < 4000) {
        text += "$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A\r\n";
      }
      while (!stopped_) {
        const ssize_t written = ::write(line_.get(), text.data(), text.size());
        if (written < 0) std::this_thread::sleep_for(std::chrono::microseconds(100));
      }
    });
  }
  void stop() {
    stopped_ = true;
    if (thread_.joinable()) thread_.join();
  }

 private:
  host::FileDescriptor line_{posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK)};
  std::string device_;
  std::atomic<bool> stopped_ = false;
  std::thread thread_;
};

TEST(NmeaFlood, HealthGoesOnAndSaysWhatComesTooOften) {
  const ScratchFolder folder;
  Flood flood;
  LiveDaemon daemon(folder, "[gnss]\ndevice = \"" + flood.device() +
                                "\"\nbaud = 115200\n"
                                "[health]\nraise_after_s = 1\n");
  daemon.wait_for("configuration ");
  flood.start();
  SocketClient client(folder / "s");
  ASSERT_TRUE(client.read_line());  // the greeting
  ASSERT_TRUE(client.send("{\"op\":\"watch\",\"classes\":[\"HEALTH\"]}\n"));
  ASSERT_TRUE(client.read_line());
  std::vector<double> stamps;
  uint64_t received = 0;
  std::string level;
  for (int reports = 0; reports < 12 && level != "ERROR"; ++reports) {
    const auto line = client.read_line();
    ASSERT_TRUE(line) << "no HEALTH for 10 s";
    const auto health = nlohmann::json::parse(*line);
    stamps.push_back(health["drive_s"]);
    for (const auto& stream : health["streams"]) {
      received = stream["received"];
      level = stream["level"];
    }
  }
  flood.stop();
  EXPECT_EQ(level, "ERROR");  // of a rate that no receiver has
  EXPECT_GT(received, 1000U);
  constexpr double kWatchdog = 5;  // s, of infused.service
  for (size_t k = 1; k < stamps.size(); ++k) EXPECT_LT(stamps[k] - stamps[k - 1], kWatchdog);
  EXPECT_EQ(daemon.stop(), 0);
  EXPECT_THAT(folder.read("log"), HasSubstr("raised (ERROR)"));
}

}  // namespace
}  // namespace infuse::daemon
