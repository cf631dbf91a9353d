#include "daemon/config/config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

/// A configuration and its drop-ins in a temporary folder.
struct ConfigFolder {
  std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("infuse-config-" + std::to_string(getpid()));
  std::filesystem::path file = folder / "infused.toml";

  ConfigFolder() { std::filesystem::create_directories(folder / "infused.toml.d"); }
  ~ConfigFolder() { std::filesystem::remove_all(folder); }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name) << text;
  }
};

TEST(Config, DropInsChangeAndAddInOrderOfTheirNames) {
  const ConfigFolder folder;
  folder.write("infused.toml",
               "log_level = \"debug\"\n[[lidar]]\nname = \"a\"\nport = 2000\n"
               "model = \"VLP-16\"\n[socket]\nmax_clients = 3\n");
  folder.write("infused.toml.d/20-second.toml", "[[lidar]]\nname = \"a\"\nport = 2002\n");
  folder.write("infused.toml.d/10-first.toml",
               "[[lidar]]\nname = \"a\"\nport = 2001\n[[lidar]]\nname = \"b\"\nport = 2010\n"
               "[socket]\nqueue_reports = 7\n");
  folder.write("infused.toml.d/README", "not read");
  const auto config = load_config(folder.file);
  ASSERT_TRUE(config) << config.error().message();
  EXPECT_EQ(config->log_level, "debug");
  ASSERT_EQ(config->lidars.size(), 2U);
  EXPECT_EQ(config->lidars[0].port, 2002);
  EXPECT_EQ(config->lidars[0].model, "VLP-16");
  EXPECT_EQ(config->lidars[1].name, "b");
  EXPECT_EQ(config->socket.max_clients, 3U);
  EXPECT_EQ(config->socket.queue_reports, 7U);
  EXPECT_EQ(config->resolve("rig.toml"), folder.folder / "rig.toml");
}

TEST(Config, AnErrorNamesItsDropIn) {
  const ConfigFolder folder;
  folder.write("infused.toml", "");
  folder.write("infused.toml.d/x.toml", "\n\nportt = 1\n");
  const auto config = load_config(folder.file);
  ASSERT_FALSE(config);
  EXPECT_THAT(config.error().where, HasSubstr("x.toml:3"));
}

TEST(Config, AFolderOfDropInsThatCannotBeListedIsAnError) {
  const ConfigFolder folder;
  folder.write("infused.toml", "");
  std::filesystem::remove(folder.folder / "infused.toml.d");
  EXPECT_TRUE(load_config(folder.file));
  folder.write("infused.toml.d", "not a folder");
  const auto config = load_config(folder.file);
  ASSERT_FALSE(config);
  EXPECT_THAT(config.error().message(), HasSubstr("infused.toml.d: cannot be listed"));
}

}  // namespace
}  // namespace infuse::daemon
