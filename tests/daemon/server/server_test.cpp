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
#include "tests/daemon/socket_client.hpp"

namespace infuse::daemon {
namespace {

using nlohmann::json;
using testing::HasSubstr;

const std::vector<Device> kDevices = {
    {"front", "lidar", "HDL-32E", "configured", "port 2368", std::nullopt}};

/// A server on a thread of its own.
class ServerTest : public testing::Test {
 protected:
  void start(const ServerOptions& options) {
    path_ = std::filesystem::temp_directory_path() /
            ("infuse-server-test-" + std::to_string(::getpid())) / "infused.sock";
    server_.emplace(io_, options, "0.1.0", "0123456789abcdef");
    const auto listening = server_->listen(path_);
    ASSERT_TRUE(listening) << listening.error().message();
    thread_ = std::thread([this] { io_.run(); });
  }

  void TearDown() override {
    if (server_) on_server([&] { server_->finish(std::chrono::milliseconds(100)); });
    work_.reset();
    if (thread_.joinable()) thread_.join();
    server_.reset();
    std::filesystem::remove_all(path_.parent_path());
  }

  /// Runs an action on the server's thread and waits for its end.
  template <class Action>
  void on_server(Action action) {
    std::promise<void> done;
    boost::asio::post(io_, [&] {
      action();
      done.set_value();
    });
    done.get_future().wait();
  }

  void publish_sweeps(int count) {
    on_server([&] {
      for (int i = 0; i < count; ++i) {
        SweepReport report;
        report.device = "front";
        report.stamp = Stamp::from_ns(++stamp_);
        report.sequence = static_cast<uint64_t>(stamp_);
        server_->publish(ReportClass::kSweep, "front", report.stamp, message(report));
      }
    });
  }

  json next(SocketClient& client) {
    const auto line = client.read_line();
    if (!line) return json{{"class", "none"}};
    EXPECT_TRUE(is_valid_message(*line));
    return json::parse(*line);
  }

  boost::asio::io_context io_;
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_{
      io_.get_executor()};  // keeps run() running until it is reset
  std::optional<Server> server_;
  std::thread thread_;
  std::filesystem::path path_;
  int64_t stamp_ = 0;
};

TEST_F(ServerTest, GreetsAndAnswersEveryOp) {
  start({});
  SocketClient client(path_);
  EXPECT_EQ(next(client)["session"], "0123456789abcdef");
  client.send("{\"op\":\"devices\"}\n");
  EXPECT_EQ(next(client)["class"], "ERROR");  // none known yet
  on_server([&] {
    server_->publish(ReportClass::kDevices, "", Stamp::from_ns(1),
                     message(DevicesReport{Stamp::from_ns(1), kDevices}));
  });
  client.send("{\"op\":\"devices\"}\n");
  EXPECT_EQ(next(client)["devices"][0]["device"], "front");
  publish_sweeps(3);
  client.send("{\"op\":\"poll\"}\n");
  EXPECT_EQ(next(client)["class"], "DEVICES");
  EXPECT_EQ(next(client)["sequence"], 3);
  EXPECT_EQ(next(client), json({{"class", "ACK"}, {"op", "poll"}}));
}

TEST_F(ServerTest, AClientReceivesTheClassesItWatchesOnly) {
  start({});
  SocketClient sweeps(path_);
  SocketClient health(path_);
  SocketClient silent(path_);
  for (SocketClient* client : {&sweeps, &health, &silent}) next(*client);
  sweeps.send("{\"op\":\"watch\",\"classes\":[\"SWEEP\"]}\n");
  health.send("{\"op\":\"watch\",\"classes\":[\"HEALTH\"]}\n");
  EXPECT_EQ(next(sweeps)["class"], "ACK");
  EXPECT_EQ(next(health)["class"], "ACK");
  publish_sweeps(2);
  EXPECT_EQ(next(sweeps)["sequence"], 1);
  EXPECT_EQ(next(sweeps)["sequence"], 2);
  EXPECT_FALSE(health.read_line(50));
  EXPECT_FALSE(silent.read_line(50));
}

TEST_F(ServerTest, InvalidRequestsAreRefusedWithAReason) {
  start({});
  SocketClient client(path_);
  next(client);
  client.send("{\"op\":\"dance\"}\n");
  EXPECT_THAT(next(client)["what"], HasSubstr("unknown op 'dance'"));
  client.send("hello\r\n");
  EXPECT_THAT(next(client)["what"], HasSubstr("not a JSON object"));
  client.send("{\"op\":\"watch\",\"classes\":[\"X\"]}\n");
  const json refused = next(client);
  EXPECT_EQ(refused["op"], "watch");
  EXPECT_THAT(refused["hint"], HasSubstr("HEALTH"));
  client.send("{\"op\":\"po");  // in two parts
  client.send("ll\"}\n{\"op\":\"poll\"}\n");
  EXPECT_EQ(next(client)["op"], "poll");
  EXPECT_EQ(next(client)["op"], "poll");
}

TEST_F(ServerTest, ControlRequestsAreAcceptedFromTheOwnerOnly) {
  start({});
  std::vector<std::string> requests;
  uint16_t port = 0;
  on_server([&] {
    port = *server_->listen_tcp(0);
    server_->on_control([&](const Request& request) -> Result<std::string> {
      requests.push_back(std::string(name_of(request.op)) + " " + request.device);
      if (request.device == "none") return fail("unknown camera 'none'", "", "ask status");
      return "begins soon";
    });
  });
  SocketClient owner(path_);
  next(owner);
  owner.send("{\"op\":\"recalibrate\",\"device\":\"front\"}\n");
  json answer = next(owner);
  EXPECT_EQ(answer["class"], "ACK");
  EXPECT_EQ(answer["op"], "recalibrate");
  EXPECT_EQ(answer["note"], "begins soon");
  owner.send("{\"op\":\"rollback\",\"device\":\"none\"}\n");
  answer = next(owner);
  EXPECT_EQ(answer["class"], "ERROR");
  EXPECT_EQ(answer["op"], "rollback");
  EXPECT_EQ(answer["what"], "unknown camera 'none'");

  boost::asio::ip::tcp::iostream tcp_client("127.0.0.1", std::to_string(port));
  tcp_client << "{\"op\":\"apply\"}\n" << std::flush;
  std::string line;
  std::getline(tcp_client, line);  // the greeting
  std::getline(tcp_client, line);
  answer = json::parse(line);
  EXPECT_TRUE(is_valid_message(line));
  EXPECT_EQ(answer["class"], "ERROR");
  EXPECT_THAT(answer["what"].get<std::string>(), HasSubstr("permission denied"));
  on_server([&] {
    EXPECT_EQ(requests, (std::vector<std::string>{"recalibrate front", "rollback none"}));
  });
}

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

TEST_F(ServerTest, AStaleSocketIsReplacedAndAFileIsNot) {
  start({});
  const auto left = path_.parent_path() / "left.sock";
  {
    boost::asio::io_context io;
    boost::asio::local::stream_protocol::acceptor acceptor(io, left.string());
  }
  ASSERT_TRUE(std::filesystem::exists(left));
  boost::asio::io_context io;
  Server second(io, {}, "0.1.0", "0123456789abcdef");
  EXPECT_TRUE(second.listen(left));
  const auto file = path_.parent_path() / "file";
  std::ofstream(file) << "precious";
  Server third(io, {}, "0.1.0", "0123456789abcdef");
  EXPECT_FALSE(third.listen(file));
  EXPECT_EQ(std::filesystem::file_size(file), 8U);
}

TEST_F(ServerTest, FinishingSendsWhatIsQueued) {
  start({});
  SocketClient client(path_);
  next(client);
  client.send("{\"op\":\"watch\"}\n");
  next(client);
  publish_sweeps(100);
  on_server([&] { server_->finish(std::chrono::milliseconds(5000)); });
  for (int i = 1; i <= 100; ++i) ASSERT_EQ(next(client)["sequence"], i);
  EXPECT_FALSE(client.read_line());
}

TEST_F(ServerTest, TcpIsServedOnTheLoopbackIfConfigured) {
  start({});
  Result<uint16_t> port = fail("");
  on_server([&] { port = server_->listen_tcp(0); });
  ASSERT_TRUE(port) << port.error().message();
  boost::asio::io_context io;
  boost::asio::ip::tcp::socket socket(io);
  socket.connect({boost::asio::ip::address_v4::loopback(), *port});
  std::array<char, 256> bytes;
  const size_t got = socket.read_some(boost::asio::buffer(bytes));
  EXPECT_THAT(std::string(bytes.data(), got), HasSubstr("\"VERSION\""));
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

TEST(ServerOptions, InvalidOptionsNameTheKey) {
  ServerOptions options;
  EXPECT_FALSE(options.invalid());
  options.path = std::string(200, 'x');
  EXPECT_THAT(options.invalid().value_or(""), HasSubstr("path"));
  options = {};
  options.queue_reports = 1;
  EXPECT_THAT(options.invalid().value_or(""), HasSubstr("queue_reports"));
  options = {};
  options.max_requests_hz = 0;
  EXPECT_THAT(options.invalid().value_or(""), HasSubstr("max_requests_hz"));
}

TEST_F(ServerTest, ServesAnAdoptedSocket) {
  const auto path = std::filesystem::temp_directory_path() /
                    ("infuse-adopted-" + std::to_string(::getpid()) + ".sock");
  const int listening = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.string().copy(address.sun_path, sizeof(address.sun_path) - 1);
  ASSERT_EQ(::bind(listening, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  ASSERT_EQ(::listen(listening, 4), 0);
  SocketClient early(path);  // before there is a daemon
  ASSERT_TRUE(early.connected());
  start({});
  on_server([&] {
    server_.emplace(io_, ServerOptions{}, "0.1.0", "0123456789abcdef");
    EXPECT_TRUE(server_->adopt(listening));
  });
  const auto greeting = early.read_line();
  ASSERT_TRUE(greeting);
  EXPECT_EQ(json::parse(*greeting)["class"], "VERSION");
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace infuse::daemon
