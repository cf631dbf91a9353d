#include "daemon/service/daemon_host.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/post.hpp>
#include <csignal>
#include <fstream>
#include <thread>

#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/daemon/socket_client.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

class DaemonHostTest : public testing::Test {
 protected:
  std::string socket() const { return (folder_ / "s").string(); }

  TemporaryFolder folder_;
  Config config_;
  Rig rig_;
};

TEST_F(DaemonHostTest, GreetsClientsUntilItIsFinished) {
  DaemonHost host(config_, {});
  ASSERT_TRUE(host.open(rig_, socket()));
  std::optional<std::string> greeting, after;
  std::thread client([&] {
    SocketClient connection(socket());
    greeting = connection.read_line();
    boost::asio::post(host.io(), [&] { host.finish(std::chrono::seconds(1)); });
    after = connection.read_line();
  });
  host.run([] {});
  client.join();
  ASSERT_TRUE(greeting.has_value());
  EXPECT_THAT(*greeting, HasSubstr("\"class\":\"VERSION\""));
  EXPECT_FALSE(after.has_value());
}

TEST_F(DaemonHostTest, ATerminationSignalRequestsTheStop) {
  DaemonHost host(config_, {});
  ASSERT_TRUE(host.open(rig_, socket()));
  boost::asio::post(host.io(), [] { std::raise(SIGTERM); });
  int stops = 0;
  host.run([&] {
    ++stops;
    host.finish(std::chrono::milliseconds(0));
  });
  EXPECT_EQ(stops, 1);
}

TEST_F(DaemonHostTest, AnUnreadableStreetMapIsAnError) {
  config_.streetmap.map = "missing.map";
  config_.folder = folder_ / "";
  DaemonHost host(config_, {});
  const auto opened = host.open(rig_, socket());
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, kUnreadable);
  EXPECT_THAT(opened.error().error.message(), HasSubstr("missing.map"));
}

TEST_F(DaemonHostTest, AnInitialPoseMustSuitTheMap) {
  CameraFrame image{.width = 40, .height = 40};
  image.pixels.assign(1600, 240);
  std::fill(image.pixels.begin(), image.pixels.begin() + 800, uint8_t{100});
  const auto map = streetmap::make_map_from_image(image, {}, "drawn");
  ASSERT_TRUE(map) << map.error().message();
  std::ofstream(folder_ / "drawn.map", std::ios::binary)
      .write(reinterpret_cast<const char*>(map->data()), static_cast<std::streamsize>(map->size()));
  config_.folder = folder_ / "";
  config_.streetmap.map = "drawn.map";
  EXPECT_TRUE(DaemonHost(config_, {}).open(rig_, socket()));
  config_.streetmap.initial_pose = InitialPose{-7e6, 0};
  const auto outside = DaemonHost(config_, {}).open(rig_, socket());
  ASSERT_FALSE(outside);
  EXPECT_THAT(outside.error().error.message(), HasSubstr("7000.0 km"));
  config_.streetmap.initial_pose.reset();
  config_.streetmap.initial_location = InitialLocation{};
  const auto opened = DaemonHost(config_, {}).open(rig_, socket());
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().error.message(), HasSubstr("latitude"));
}

TEST_F(DaemonHostTest, ASocketThatCannotBeCreatedIsAnErrorIfItWasRequested) {
  std::ofstream(folder_ / "file") << "x";
  DaemonHost host(config_, {});
  const auto opened = host.open(rig_, (folder_ / "file" / "s").string());
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, kUsage);
}

TEST_F(DaemonHostTest, ThePipelineGetsTheConfiguration) {
  config_.health.stale_after = from_seconds(7);
  DaemonHost host(config_, {});
  ASSERT_TRUE(host.open(rig_, socket()));
  const PipelineOptions options = host.pipeline_options();
  EXPECT_EQ(options.health.stale_after, from_seconds(7));
  EXPECT_TRUE(options.maps.street_map.map.empty());
}

}  // namespace
}  // namespace infuse::daemon
