#include "daemon/config/config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

constexpr const char* kFull = R"(log_level = "debug"

[socket]
path = "/tmp/x.sock"
tcp_port = 2947
max_clients = 8
idle_timeout_s = 1.5
queue_reports = 16
max_requests_hz = 10

[health]
stale_after_s = 2
raise_after_s = 0.5
clear_after_s = 4
clock_grace_s = 20
warn_loss = 0.01
error_loss = 0.1

[[lidar]]
name = "front"
model = "HDL-32E"
port = 2370
sender = "192.168.1.201"
)";

TEST(Config, AnEmptyFileGivesTheDefaults) {
  const auto config = parse_config("", "x.toml");
  ASSERT_TRUE(config);
  EXPECT_EQ(config->socket.max_clients, 64U);
  EXPECT_EQ(config->health.stale_after, from_seconds(3));
  EXPECT_TRUE(config->lidars.empty());
}

TEST(Config, EveryKeyIsRead) {
  const auto config = parse_config(kFull, "x.toml");
  ASSERT_TRUE(config) << config.error().message();
  EXPECT_EQ(config->log_level, "debug");
  EXPECT_EQ(config->socket.path, "/tmp/x.sock");
  EXPECT_EQ(config->socket.tcp_port, 2947);
  EXPECT_EQ(config->socket.max_clients, 8U);
  EXPECT_EQ(config->socket.idle_timeout, from_seconds(1.5));
  EXPECT_EQ(config->socket.queue_reports, 16U);
  EXPECT_EQ(config->socket.max_requests_hz, 10);
  EXPECT_EQ(config->health.stale_after, from_seconds(2));
  EXPECT_EQ(config->health.raise_after, from_seconds(0.5));
  EXPECT_EQ(config->health.clear_after, from_seconds(4));
  EXPECT_EQ(config->health.clock_grace, from_seconds(20));
  EXPECT_EQ(config->health.warn_loss, 0.01);
  EXPECT_EQ(config->health.error_loss, 0.1);
  ASSERT_EQ(config->lidars.size(), 1U);
  EXPECT_EQ(config->lidars[0].name, "front");
  EXPECT_EQ(config->lidars[0].model, "HDL-32E");
  EXPECT_EQ(config->lidars[0].port, 2370);
  EXPECT_EQ(config->lidars[0].sender, "192.168.1.201");
}

TEST(Config, ListsTheKeysThatDiffer) {
  const auto read = [](const char* text) {
    auto config = parse_config(text, "x.toml");
    EXPECT_TRUE(config) << config.error().message();
    return config.value_or(Config{});
  };
  const char* one = "log_level = \"info\"\n[health]\nwarn_loss = 0.01\n[[lidar]]\nport = 1\n";
  EXPECT_TRUE(changed_keys(read(one), read(one)).empty());
  const char* spaced = "# why\nlog_level='info'\n\n[health]\nwarn_loss=0.01\n[[lidar]]\nport=1\n";
  EXPECT_TRUE(changed_keys(read(one), read(spaced)).empty());
  EXPECT_THAT(changed_keys(read(one), read("[health]\nwarn_loss = 0.01\n[[lidar]]\nport = 2\n")),
              testing::ElementsAre("lidar", "log_level"));
  EXPECT_THAT(changed_keys(read(""), read("rig = \"r\"\n")), testing::ElementsAre("rig"));
}

struct Wrong {
  const char* text;
  const char* message;
};

TEST(Config, ErrorsNameTheLineAndTheProblem) {
  const std::string long_name = "[[lidar]]\nname = \"" + std::string(10'000, 'x') + "\"";
  const Wrong cases[] = {
      {"\n[health]\nstale_after = 3\n", "x.toml:3: unknown key 'stale_after'"},
      {"\n[health]\nstale_after = 3\n", "known keys: stale_after_s, raise_after_s"},
      {"[socket]\npath = 3", "x.toml:2: path must be a string in quotes"},
      {"[socket]\nmax_clients = 1.5", "x.toml:2: max_clients must be an integer"},
      {"[socket]\ntcp_port = 65536", "tcp_port must be an integer from 0 to 65535"},
      {"[socket]\nmax_clients = 0", "x.toml:1: socket: max_clients must be between"},
      {"[health]\nwarn_loss = \"1\"", "x.toml:2: warn_loss must be a number"},
      {"[health]\nwarn_loss = nan", "warn_loss must be a finite number"},
      {"socket = 1", "socket must be a table"},
      {"lidar = 1", "tables: [[lidar]]"},
      {"lidar = [1]", "tables: [[lidar]]"},
      {"[[lidar]]\n[[lidar]]", "x.toml:2: two lidars are named 'lidar'"},
      {"[[lidar]]\nname = \"a\\nb\"", "a name has 1 to 64 bytes and no control characters"},
      {long_name.c_str(), "a name has 1 to 64 bytes and no control characters"},
      {"[odometry]\nimu_delay_ms = 1e300", "imu_delay_ms must be between -10000 and 10000"},
      {"log_level = \"loud\"", "log_level is none of"},
      {"a = = 1", "x.toml:1:"},
      {"[socket\n", "x.toml:1:"}};
  for (const Wrong& wrong : cases) {
    const auto config = parse_config(wrong.text, "x.toml");
    ASSERT_FALSE(config) << wrong.text;
    EXPECT_THAT(config.error().message(), HasSubstr(wrong.message));
  }
}

TEST(Config, AMissingFileIsAnError) {
  const auto config = load_config("/nonexistent/infused.toml");
  ASSERT_FALSE(config);
  EXPECT_EQ(config.error().where, "/nonexistent/infused.toml");
  EXPECT_FALSE(load_config("/"));
}

TEST(Config, SizeAndDepthAreBounded) {
  EXPECT_FALSE(parse_config(std::string(2 << 20, '\n'), "x.toml"));
  EXPECT_FALSE(parse_config("a = " + std::string(100'000, '['), "x.toml"));
}

TEST(Config, TenThousandMutatedFilesAreEachReadOrRefusedWithAReason) {
  std::mt19937 random(2);
  int refused = 0;
  for (int i = 0; i < 10'000; ++i) {
    std::string text = kFull;
    for (unsigned edits = 1 + random() % 4; edits > 0; --edits) {
      const size_t place = random() % text.size();
      if (random() % 2 == 0) {
        text[place] = static_cast<char>(random());
      } else {
        text.erase(place, random() % 8);
      }
    }
    const auto config = parse_config(text, "x.toml");
    if (config) continue;
    ++refused;
    EXPECT_THAT(config.error().where, testing::StartsWith("x.toml"));
    EXPECT_FALSE(config.error().what.empty());
  }
  EXPECT_GT(refused, 5000);
  EXPECT_LT(refused, 10'000);
}

}  // namespace
}  // namespace infuse::daemon
