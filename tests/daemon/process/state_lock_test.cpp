#include "daemon/process/state_lock.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <optional>

#include "daemon/process/service_user.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

TEST(StateLock, OneProcessHasAStateDirectory) {
  const ScratchFolder folder;
  auto first = lock_state(folder.path());
  ASSERT_TRUE(first) << first.error().message();
  const auto second = lock_state(folder.path());
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().message().find("another infused uses this state directory"),
            std::string::npos);
  *first = host::FileDescriptor();
  EXPECT_TRUE(lock_state(folder.path()));
  EXPECT_TRUE(lock_state(folder / "missing"));
}

TEST(ServiceUser, RootChecksWithTheRightsOfTheService) {
  if (::geteuid() != 0) {
    EXPECT_FALSE(become_user("nobody").value());
    return;
  }
  const ScratchFolder folder;
  folder.write("secret", "");
  std::filesystem::permissions(folder / "secret", std::filesystem::perms(0600));
  EXPECT_EXIT(
      {
        const bool changed = become_user("nobody").value_or(false);
        const bool readable = ::access((folder / "secret").c_str(), R_OK) == 0;
        ::_exit(changed && !readable ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
  EXPECT_FALSE(become_user("no-such-user").value());
}

}  // namespace
}  // namespace infuse::daemon
