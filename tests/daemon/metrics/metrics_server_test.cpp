#include "daemon/metrics/metrics_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <boost/asio/ip/tcp.hpp>
#include <deque>
#include <thread>

#include "tests/daemon/socket_client.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

class MetricsServerTest : public testing::Test {
 protected:
  MetricsServerTest() {
    path_ =
        std::filesystem::temp_directory_path() / ("infuse-metrics-" + std::to_string(::getpid()));
    server_.set_text("infuse_up 1\n");
    EXPECT_TRUE(server_.listen(path_));
    thread_ = std::thread([this] { io_.run(); });
  }
  ~MetricsServerTest() override {
    boost::asio::post(io_, [this] { server_.finish(); });
    thread_.join();
  }

  /// The response, up to the end of the connection.
  static std::string read_response(SocketClient& client) {
    std::string all;
    while (const auto line = client.read_line()) all += *line + "\n";
    return all;
  }
  std::string send_request(const std::string& request) {
    SocketClient client(path_);
    EXPECT_TRUE(client.connected());
    client.send(request);
    return read_response(client);
  }

  boost::asio::io_context io_{1};
  MetricsServer server_{io_};
  std::filesystem::path path_;
  std::thread thread_;
};

TEST_F(MetricsServerTest, AnswersAScrape) {
  const std::string got = send_request("GET /metrics HTTP/1.1\r\nHost: x\r\nAccept: */*\r\n\r\n");
  EXPECT_THAT(got, StartsWith("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(got, HasSubstr("Content-Type: text/plain; version=0.0.4"));
  EXPECT_THAT(got, HasSubstr("Content-Length: 12\r\n"));
  EXPECT_THAT(got, HasSubstr("\r\n\r\ninfuse_up 1\n"));
  EXPECT_THAT(send_request("GET /metrics?x=1 HTTP/1.0\r\n\r\n"), HasSubstr(" 200 OK"));
  const std::string head = send_request("HEAD /metrics HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_THAT(head, HasSubstr("Content-Length: 12\r\n"));
  EXPECT_EQ(head.find("infuse_up"), std::string::npos);
}

TEST_F(MetricsServerTest, RefusesEverythingElse) {
  EXPECT_THAT(send_request("GET / HTTP/1.1\r\n\r\n"), HasSubstr(" 404 "));
  EXPECT_THAT(send_request("GET /../metrics HTTP/1.1\r\n\r\n"), HasSubstr(" 404 "));
  EXPECT_THAT(send_request("POST /metrics HTTP/1.1\r\nContent-Length: 5\r\n\r\nhello"),
              HasSubstr(" 405 "));
  EXPECT_THAT(send_request("DELETE /metrics HTTP/1.1\r\n\r\n"), HasSubstr(" 405 "));
  EXPECT_THAT(send_request("this is no HTTP at all\r\n\r\n"), HasSubstr(" 400 "));
  EXPECT_THAT(send_request(std::string(100, '\0') + "\r\n\r\n"), HasSubstr(" 400 "));
  EXPECT_THAT(send_request("GET /metrics HTTP/9.9\r\n\r\n"), HasSubstr(" 400 "));
  EXPECT_THAT(send_request("GET /metrics HTTP/1.1\r\nX: " + std::string(10'000, 'x') + "\r\n\r\n"),
              HasSubstr(" 431 "));
  EXPECT_THAT(send_request("GET /" + std::string(100'000, 'x')), HasSubstr(" 431 "));
  EXPECT_THAT(send_request("GET /metrics HTTP/1.1\r\n\r\n"), HasSubstr(" 200 OK"));
}

TEST_F(MetricsServerTest, OverTcpTheHostMustBeThisComputer) {
  const auto port = server_.listen_tcp(0);
  ASSERT_TRUE(port.has_value());
  const std::pair<const char*, const char*> cases[] = {
      {"localhost", " 200 OK"},   {"localhost:9464", " 200 OK"}, {"127.0.0.1:1", " 200 OK"},
      {"[::1]:9464", " 200 OK"},  {"[::1]", " 200 OK"},          {"evil.example", " 421 "},
      {"localhost.evil", " 421 "}};
  for (const auto& [host, expected] : cases) {
    boost::asio::ip::tcp::iostream client("127.0.0.1", std::to_string(*port));
    client << "GET /metrics HTTP/1.1\r\nHost: " << host << "\r\n\r\n" << std::flush;
    std::string line;
    std::getline(client, line);
    EXPECT_THAT(line, HasSubstr(expected)) << host;
  }
}

TEST_F(MetricsServerTest, ARequestWithoutEndTimesOut) {
  SocketClient silent(path_);
  SocketClient begun(path_);
  begun.send("GET /metrics HTTP/1.1\r\nX: y");
  EXPECT_EQ(silent.read_line(10'000), std::nullopt);
  EXPECT_EQ(read_response(begun), "");
  EXPECT_THAT(send_request("GET /metrics HTTP/1.1\r\n\r\n"), HasSubstr(" 200 OK"));
}

TEST_F(MetricsServerTest, AThousandConnectionsLeaveNoTrace) {
  {
    std::deque<SocketClient> clients;
    int connected = 0;
    for (int i = 0; i < 1000; ++i) connected += clients.emplace_back(path_).connected() ? 1 : 0;
    EXPECT_EQ(connected, 1000);
  }
  std::string got;
  for (int i = 0; i < 100 && got.find("200 OK") == std::string::npos; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    got = send_request("GET /metrics HTTP/1.1\r\n\r\n");
  }
  EXPECT_THAT(got, HasSubstr(" 200 OK"));
}

TEST_F(MetricsServerTest, OnlyOwnerAndGroupMayConnect) {
  struct stat status {};
  ASSERT_EQ(::stat(path_.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0660U);
  boost::asio::io_context io;
  MetricsServer second(io);
  EXPECT_FALSE(second.listen(path_));
  const auto port = second.listen_tcp(0);
  ASSERT_TRUE(port);
  EXPECT_FALSE(MetricsServer(io).listen_tcp(*port));
}

}  // namespace
}  // namespace infuse::daemon
