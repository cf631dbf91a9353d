#include "daemon/server/client_limits.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

constexpr ClientUser kOwner{0, true};
constexpr ClientUser kMember{1000, false}, kOtherMember{1001, false};
constexpr ClientUser kTcp{std::nullopt, false};

/// Connects clients until one is refused, and returns how many were accepted.
size_t connect_all(const ClientUser& client, std::vector<ClientUser>& connected,
                   const ServerOptions& options) {
  size_t accepted = 0;
  while (!refuse_client(client, connected, options)) {
    connected.push_back(client);
    ++accepted;
  }
  return accepted;
}

TEST(ClientLimits, OneUserCannotTakeAllPlaces) {
  std::vector<ClientUser> connected;
  EXPECT_EQ(connect_all(kMember, connected, {}), 16U);
  EXPECT_EQ(connect_all(kTcp, connected, {}), 16U);
  EXPECT_THAT(*refuse_client(kMember, connected, {}), HasSubstr("of user 1000: 16"));
  EXPECT_THAT(*refuse_client(kTcp, connected, {}), HasSubstr("of TCP: 16"));
  EXPECT_FALSE(refuse_client(kOtherMember, connected, {}));
}

TEST(ClientLimits, PlacesAreKeptForTheOwner) {
  std::vector<ClientUser> connected;
  const ServerOptions options{.max_clients = 20, .max_clients_per_user = 20};
  EXPECT_EQ(connect_all(kMember, connected, options), 20U);
  EXPECT_THAT(*refuse_client(kOtherMember, connected, options), HasSubstr("too many clients: 20"));
  EXPECT_EQ(connect_all(kOwner, connected, options), kOwnerPlaces);
}

TEST(ClientLimits, ABucketPermitsABurstAndThenTheRate) {
  using std::chrono::milliseconds;
  const ServerClock::time_point start{};
  TokenBucket bucket(10, start);
  EXPECT_TRUE(bucket.full(start));
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(bucket.take(start));
  EXPECT_FALSE(bucket.take(start));
  EXPECT_FALSE(bucket.take(start + milliseconds(50)));
  EXPECT_TRUE(bucket.take(start + milliseconds(110)));
  EXPECT_FALSE(bucket.take(start + milliseconds(115)));
  EXPECT_FALSE(bucket.full(start + milliseconds(900)));
  EXPECT_TRUE(bucket.full(start + milliseconds(2000)));
}

TEST(ClientLimits, RefusalsAreSummedUp) {
  const ServerClock::time_point start{};
  RefusalLog log;
  EXPECT_FALSE(log.due_line(start));
  log.add("full");
  EXPECT_EQ(log.due_line(start), "a client was refused; full");
  for (int i = 0; i < 1000; ++i) {
    log.add("full");
    EXPECT_FALSE(log.due_line(start + std::chrono::milliseconds(i)));
  }
  EXPECT_EQ(log.due_line(start + RefusalLog::kPeriod), "1000 clients were refused; full");
  EXPECT_FALSE(log.due_line(start + 2 * RefusalLog::kPeriod));
}

}  // namespace
}  // namespace infuse::daemon
