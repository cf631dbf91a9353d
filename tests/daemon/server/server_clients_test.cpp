#include "daemon/server/server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>
#include <future>
#include <random>
#include <thread>

#include "daemon/protocol/messages.hpp"
#include "tests/daemon/schema.hpp"
#include "tests/daemon/server/server_fixture.hpp"
#include "tests/daemon/socket_client.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

TEST_F(ServerTest, ARequestWithoutEndIsRefusedAndTheConnectionClosed) {
  start({});
  SocketClient client(path_);
  next(client);
  client.send(std::string(kMaxRequestBytes + 1, 'x'));
  EXPECT_THAT(next(client)["what"], HasSubstr("longer than 4096 bytes"));
  EXPECT_FALSE(client.read_line());
}

TEST_F(ServerTest, TooManyRequestsEndTheConnection) {
  ServerOptions options;
  options.max_requests_hz = 5;
  start(options);
  SocketClient client(path_);
  next(client);
  for (int i = 0; i < 20; ++i) client.send("{\"op\":\"poll\"}\n");
  int answered = 0;
  json message = next(client);
  for (; message["class"] == "ACK"; message = next(client)) ++answered;
  EXPECT_GE(answered, 5);
  EXPECT_LT(answered, 20);
  EXPECT_THAT(message["what"], HasSubstr("too many requests"));
  EXPECT_FALSE(client.read_line());
}

TEST_F(ServerTest, ASlowClientLosesReportsAndGetsTheirNumber) {
  ServerOptions options;
  options.queue_reports = 16;
  start(options);
  SocketClient slow(path_);
  SocketClient quick(path_);
  next(slow);
  next(quick);
  slow.send("{\"op\":\"watch\",\"classes\":[\"SWEEP\"]}\n");
  quick.send("{\"op\":\"watch\",\"classes\":[\"SWEEP\"]}\n");
  next(slow);
  next(quick);

  constexpr uint64_t kRounds = 400, kBatch = 10;
  uint64_t quick_received = 0;
  for (uint64_t round = 0; round < kRounds; ++round) {  // more than the buffers of a socket hold
    publish_sweeps(kBatch);
    for (uint64_t i = 0; i < kBatch; ++i) quick_received += next(quick)["class"] == "SWEEP";
  }
  EXPECT_EQ(quick_received, kRounds * kBatch);

  // Every sequence number reaches the slow client, or is counted in a LOST.
  uint64_t expected = 1;
  uint64_t lost = 0;
  const auto read_all = [&] {
    while (const auto line = slow.read_line(100)) {
      ASSERT_TRUE(is_valid_message(*line));
      const json message = json::parse(*line);
      if (message["class"] == "LOST") {
        lost += message["reports"].get<uint64_t>();
        expected += message["reports"].get<uint64_t>();
      } else {
        ASSERT_EQ(message["sequence"].get<uint64_t>(), expected);
        ++expected;
      }
    }
  };
  read_all();
  publish_sweeps(1);
  read_all();
  EXPECT_GT(lost, 0U);
  EXPECT_EQ(expected, kRounds * kBatch + 2);
}

TEST_F(ServerTest, AClientBeyondTheLimitIsRejectedAndThereIsRoomWhenOneLeaves) {
  start({.max_clients = 20});
  constexpr int kPlaces = 20 + kOwnerPlaces;  // the test is the owner
  std::vector<std::unique_ptr<SocketClient>> clients;
  for (int i = 0; i < kPlaces; ++i) {
    clients.push_back(std::make_unique<SocketClient>(path_));
    ASSERT_EQ(next(*clients.back())["class"], "VERSION") << i;
  }
  for (int i = 0; i < 10; ++i) {
    SocketClient extra(path_);
    EXPECT_THAT(next(extra)["what"], HasSubstr("too many clients: 28"));
    EXPECT_FALSE(extra.read_line());
  }
  clients.pop_back();
  json greeting;
  for (int i = 0; i < 100 && greeting["class"] != "VERSION"; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    clients.push_back(std::make_unique<SocketClient>(path_));
    greeting = next(*clients.back());
  }
  EXPECT_EQ(greeting["class"], "VERSION");
}

TEST_F(ServerTest, AnIdleClientIsDisconnected) {
  ServerOptions options;
  options.idle_timeout = std::chrono::milliseconds(100);
  start(options);
  SocketClient client(path_);
  EXPECT_EQ(next(client)["class"], "VERSION");
  EXPECT_FALSE(client.read_line());
  size_t clients = 1;
  on_server([&] { clients = server_->client_count(); });
  EXPECT_EQ(clients, 0U);
}

TEST_F(ServerTest, OnlyOwnerAndGroupMayConnectAndASecondServerFails) {
  start({});
  struct stat status {};
  ASSERT_EQ(::stat(path_.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0660U);
  boost::asio::io_context io;
  Server second(io, {}, "0.1.0", "0123456789abcdef");
  const auto listening = second.listen(path_);
  ASSERT_FALSE(listening);
  EXPECT_THAT(listening.error().what, HasSubstr("another infused"));
}

TEST_F(ServerTest, TenThousandMutatedRequestsAreEachAnswered) {
  ServerOptions options;
  options.max_requests_hz = 1e6;
  start(options);
  SocketClient client(path_);
  next(client);
  const std::string seed = R"({"op":"watch","classes":["HEALTH","ALERT"]})";
  std::mt19937 random(3);
  for (int i = 0; i < 10'000; ++i) {
    std::string line = i % 2 == 0 ? seed : R"({"op":"poll"})";
    for (unsigned edits = random() % 4; edits > 0; --edits) {
      line[random() % line.size()] = static_cast<char>(random());
    }
    std::replace(line.begin(), line.end(), '\n', ' ');
    ASSERT_TRUE(client.send(line + "\n"));
    const auto answer = client.read_line();
    ASSERT_TRUE(answer) << line;
    const json message = json::parse(*answer);
    ASSERT_TRUE(message["class"] == "ACK" || message["class"] == "ERROR");
    if (i % 50 == 0) {
      ASSERT_TRUE(is_valid_message(*answer));
    }
  }
}

}  // namespace
}  // namespace infuse::daemon
