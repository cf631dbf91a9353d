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

#include "daemon/protocol/messages.hpp"
#include "tests/daemon/schema.hpp"
#include "tests/daemon/server/server_fixture.hpp"
#include "tests/daemon/socket_client.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

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
