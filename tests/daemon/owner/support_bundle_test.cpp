#include "daemon/owner/support_bundle.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/daemon/run_program.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr const char* kConfiguration =
    "[view]\nport = 9468\ntoken = \"abcdefghijklmnop\"\n"
    "[mqtt]\npassword_file = \"/etc/infuse/password\"\n"
    "[streetmap]\nmap = \"http://me:hunter2@maps/town.map\"\n";

TEST(SupportBundle, LeavesSecretsOutOfEveryText) {
  SupportBundle bundle;
  bundle.hide_secrets_of(kConfiguration);
  bundle.add("config/infused.toml", kConfiguration);
  bundle.add("journal.txt", "view: http://car/?token=abcdefghijklmnop\n");
  const std::string tar = bundle.tar("car");
  EXPECT_THAT(tar, Not(HasSubstr("abcdefghijklmnop")));
  EXPECT_THAT(tar, Not(HasSubstr("hunter2")));
  EXPECT_THAT(tar, HasSubstr("/etc/infuse/password"));  // a name of a file, which is not read
}

TEST(SupportBundle, TarReadsTheArchive) {
  const ScratchFolder folder;
  SupportBundle bundle;
  const std::string text(1000, 'x');
  bundle.add("a/b.txt", text);
  bundle.add("empty.txt", "");
  bundle.add("end.txt", "end");
  ASSERT_TRUE(bundle.write(folder / "car.tar.zst"));
  folder.write("car.tar", bundle.tar("car"));
  const auto extracted = run_shell_command("tar -C " + folder.path().string() + " -xf " +
                                           (folder / "car.tar").string() + " 2>&1");
  EXPECT_EQ(extracted.code, 0) << extracted.output;
  EXPECT_EQ(folder.read("car/a/b.txt"), text);
  EXPECT_EQ(folder.read("car/end.txt"), "end");
  EXPECT_EQ(std::filesystem::file_size(folder / "car/empty.txt"), 0U);
  EXPECT_EQ(folder.read("car.tar.zst").substr(0, 4), "\x28\xb5\x2f\xfd");
}

}  // namespace
}  // namespace infuse::daemon
