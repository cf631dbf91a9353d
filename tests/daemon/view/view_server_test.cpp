#include "daemon/view/view_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <cstring>
#include <filesystem>
#include <thread>

#include "tests/daemon/view/small_sweep.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::ip::tcp;
using namespace std::chrono_literals;

class ViewServerTest : public testing::Test {
 protected:
  using Page = beast::websocket::stream<tcp::socket>;

  std::unique_ptr<ViewServer> start(ReplayControl control = nullptr) {
    auto server = ViewServer::start(settings_, small_rig(), {}, tap_, std::move(control));
    EXPECT_TRUE(server) << server.error().message();
    return *std::move(server);
  }

  tcp::socket connect(const ViewServer& server) {
    tcp::socket socket(io_);
    socket.connect({asio::ip::make_address("127.0.0.1"), server.port()});
    return socket;
  }

  /// The whole response to these bytes.
  std::string ask(const ViewServer& server, const std::string& bytes) {
    tcp::socket socket = connect(server);
    beast::error_code ignored;
    asio::write(socket, asio::buffer(bytes), ignored);
    std::string response;
    asio::read(socket, asio::dynamic_buffer(response), ignored);
    return response;
  }

  Page open(const ViewServer& server) {
    Page page(connect(server));
    page.handshake("127.0.0.1:" + std::to_string(server.port()), "/stream");
    return page;
  }

  static std::string read(Page& page) {
    beast::flat_buffer buffer;
    page.read(buffer);
    return beast::buffers_to_string(buffer.data());
  }

  static bool wait_until(const std::function<bool()>& condition) {
    for (int k = 0; k < 1000 && !condition(); ++k) std::this_thread::sleep_for(10ms);
    return condition();
  }

  ViewSettings settings_;  // port 0: any free one
  ViewTap tap_{1};
  asio::io_context io_;
};

TEST_F(ViewServerTest, WhoConnectsAndAsksNothingGivesWay) {
  const auto server = start();
  std::vector<tcp::socket> silent;
  for (int k = 0; k < 64; ++k) silent.push_back(connect(*server));
  const std::string page = ask(*server, "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(page.rfind("HTTP/1.1 200", 0), 0u) << page.substr(0, 200);
}

TEST_F(ViewServerTest, ServesAUnixSocketForItsGroup) {
  const ScratchFolder folder;
  settings_.path = folder / "view.sock";
  {
    const auto server = start();
    EXPECT_EQ(server->address(), settings_.path);
    EXPECT_EQ(std::filesystem::status(settings_.path).permissions(), std::filesystem::perms(0660));
    asio::local::stream_protocol::socket socket(io_);
    socket.connect(settings_.path);
    asio::write(socket, asio::buffer(std::string("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")));
    std::string response;
    beast::error_code ignored;
    asio::read(socket, asio::dynamic_buffer(response), ignored);
    EXPECT_EQ(response.rfind("HTTP/1.1 200", 0), 0u) << response.substr(0, 200);
  }
  EXPECT_FALSE(std::filesystem::exists(settings_.path));
}

TEST_F(ViewServerTest, TheAddressForTheLogHasNoToken) {
  settings_.token = "abcdefghijklmnop";
  const auto server = start();
  EXPECT_EQ(server->address().find(settings_.token), std::string::npos);
  EXPECT_NE(server->page_address().find(settings_.token), std::string::npos);
}

TEST_F(ViewServerTest, ServesThePageWithAStrictPolicy) {
  const auto server = start();
  for (const auto& [path, type] : {std::pair("/", "text/html"),
                                   {"/view.js", "text/javascript"},
                                   {"/scene.js", "text/javascript"},
                                   {"/style.css", "text/css"}}) {
    const std::string response =
        ask(*server, std::string("GET ") + path + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_EQ(response.rfind("HTTP/1.1 200", 0), 0u) << response.substr(0, 200);
    EXPECT_NE(response.find(type), std::string::npos) << path;
    EXPECT_NE(response.find("default-src 'none'"), std::string::npos);
    EXPECT_EQ(response.find("unsafe"), std::string::npos);
  }
  const std::string page = ask(*server, "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_NE(page.find("<canvas id=\"points\">"), std::string::npos);
  EXPECT_EQ(page.find("onclick="), std::string::npos);
  EXPECT_EQ(page.find(" style="), std::string::npos);
}

TEST_F(ViewServerTest, OtherRequestsAreRefusedAndTheServerLives) {
  const auto server = start();
  const auto status = [&](const std::string& bytes) {
    const std::string response = ask(*server, bytes);
    return response.size() > 12 ? response.substr(9, 3) : "";
  };
  const std::string host = " HTTP/1.1\r\nHost: localhost\r\n";
  EXPECT_EQ(status("POST /" + host + "Content-Length: 0\r\n\r\n"), "405");
  EXPECT_EQ(status("GET /../../etc/passwd" + host + "\r\n"), "404");
  EXPECT_EQ(status("GET /%2e%2e/etc/passwd" + host + "\r\n"), "404");
  EXPECT_EQ(status("GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n"), "403");
  EXPECT_EQ(status("GET / HTTP/1.1\r\n\r\n"), "400");
  EXPECT_EQ(status("GET / HTTP/1.1\r\nHost: localhost\r\nHost: evil.example\r\n\r\n"), "400");
  EXPECT_EQ(status("GET /stream" + host + "\r\n"), "426");
  EXPECT_EQ(
      status("GET /stream" + host +
             "Origin: http://evil.example\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
             "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"),
      "403");
  EXPECT_EQ(status("GET /" + host + "X: " + std::string(20'000, 'x') + "\r\n\r\n"), "");
  EXPECT_EQ(status("POST /" + host + "Content-Length: 1000000\r\n\r\n" + std::string(100'000, 'x')),
            "");
  EXPECT_EQ(status("\x16\x03\x01\x02\r\n\r\n"), "");
  EXPECT_EQ(status(std::string(100, '\0') + "\r\n\r\n"), "");
  EXPECT_EQ(status("GET /" + host + "\r\n"), "200");
}

TEST_F(ViewServerTest, APageGetsReportsSweepsAndTheLastStates) {
  const auto server = start();
  server->publish(ReportClass::kHealth, R"({"class":"HEALTH","n":1})");
  server->publish(ReportClass::kSweep, R"({"class":"SWEEP"})");  // nobody looks
  Page page = open(*server);
  EXPECT_EQ(read(page), R"({"class":"VIEW","form":1,"replay":false})");
  EXPECT_EQ(read(page), R"({"class":"HEALTH","n":1})");
  ASSERT_TRUE(wait_until([&] { return tap_.wanted(); }));
  tap_.add_sweep(SmallSweep(3).snapshot(), nullptr);
  const std::string binary = read(page);
  EXPECT_TRUE(page.got_binary());
  EXPECT_EQ(Frame(binary).points(), 3u);
  server->publish(ReportClass::kSweep, R"({"class":"SWEEP"})");
  EXPECT_EQ(read(page), R"({"class":"SWEEP"})");
  page.close(beast::websocket::close_code::normal);
  EXPECT_TRUE(wait_until([&] { return server->clients() == 0; }));
  EXPECT_TRUE(wait_until([&] { return !tap_.wanted(); }));
}

TEST_F(ViewServerTest, APageOpenedLaterGetsTheReportsSinceTheStartAndTheEnd) {
  std::atomic<int> opened = 0;
  const auto server = start([&](const ViewCommand& command) {
    opened += command.kind == ViewCommand::Kind::kOpened ? 1 : 0;
  });
  server->publish(ReportClass::kHealth, R"({"class":"HEALTH","n":1})");
  server->publish(ReportClass::kHealth, R"({"class":"HEALTH","n":2})");
  server->publish(ReportClass::kAlert, R"({"class":"ALERT"})");
  server->publish(ReportClass::kPose, R"({"class":"POSE"})");
  Page early = open(*server);
  ASSERT_TRUE(wait_until([&] { return tap_.wanted(); }));
  tap_.add_sweep(SmallSweep(3).snapshot(), nullptr);
  while (!early.got_binary()) read(early);
  server->end_drive();
  while (early.got_binary()) EXPECT_EQ(read(early), R"({"class":"END"})");
  Page late = open(*server);
  EXPECT_EQ(opened, 2);
  EXPECT_EQ(read(late), R"({"class":"VIEW","form":1,"replay":true})");
  EXPECT_EQ(
      read(late),
      "{\"class\":\"HEALTH\",\"n\":1}\n{\"class\":\"HEALTH\",\"n\":2}\n{\"class\":\"ALERT\"}");
  EXPECT_EQ(Frame(read(late)).points(), 3u);
  EXPECT_EQ(read(late), R"({"class":"END"})");
}

TEST_F(ViewServerTest, ASlowPageLosesMessagesAndIsTold) {
  const auto server = start();
  Page slow = open(*server), quick = open(*server);
  read(slow);
  read(quick);
  const std::string large = R"({"class":"POSE","x":")" + std::string(20'000, 'x') + "\"}";
  for (int k = 0; k < 3000; ++k) {  // 60 MB, beyond what sockets hold
    server->publish(ReportClass::kPose, large);
    ASSERT_EQ(read(quick), large);
  }
  bool told = false;
  for (int k = 0; k < 3000 && !told; ++k)
    told = read(slow).rfind(R"({"class":"LOST","count":)", 0) == 0;
  EXPECT_TRUE(told);
}

TEST_F(ViewServerTest, ASlowPageGetsTheNewestSweep) {
  const auto server = start();
  Page slow = open(*server), quick = open(*server);
  read(slow);
  read(quick);
  SmallSweep large(ViewTap::kMaxPoints);
  std::string last;
  for (int k = 0; k < 60; ++k) {  // 19 MB, beyond what sockets hold; then the replay is held
    large.at.reference += 1ms;
    tap_.add_sweep(large.snapshot(), nullptr);
    last = Frame(read(quick)).header["stamp"];
  }
  ASSERT_EQ(last, std::to_string(large.at.reference.ns()));
  server->publish(ReportClass::kHealth, "{}");
  std::string seen;
  for (std::string message; message != "{}"; message = read(slow)) {
    if (!message.empty() && slow.got_binary()) seen = Frame(message).header["stamp"];
  }
  EXPECT_EQ(seen, last);
}

TEST_F(ViewServerTest, PagesAreLimited) {
  settings_.max_clients = 2;
  const auto server = start();
  Page one = open(*server), two = open(*server);
  Page three(connect(*server));
  beast::error_code refused;
  three.handshake("127.0.0.1:1", "/stream", refused);
  EXPECT_TRUE(refused);
  one.next_layer().close();
  EXPECT_TRUE(wait_until([&] { return server->clients() == 1; }));
  Page four = open(*server);
}

TEST_F(ViewServerTest, OnlyAReplayTakesACommandAndOnlyOne) {
  std::vector<double> rates;
  std::mutex mutex;
  {
    const auto server = start([&](const ViewCommand& command) {
      const std::lock_guard lock(mutex);
      if (command.kind == ViewCommand::Kind::kOpened) return;
      rates.push_back(command.rate);
    });
    Page page = open(*server);
    EXPECT_EQ(read(page), R"({"class":"VIEW","form":1,"replay":true})");
    for (const char* text : {"{\"rate\":2}", "{\"rate\":-1}", "{\"rate\":1e9}", "{\"rate\":\"2\"}",
                             "{\"op\":\"apply\"}", "[[[[", "{\"rate\":0}"}) {
      page.write(asio::buffer(std::string(text)));
    }
    EXPECT_TRUE(wait_until([&] {
      const std::lock_guard lock(mutex);
      return rates.size() == 2;
    }));
    beast::error_code closed;
    page.write(asio::buffer(std::string(5000, 'x')), closed);  // too long
    EXPECT_TRUE(wait_until([&] { return server->clients() == 0; }));
  }
  EXPECT_EQ(rates, (std::vector<double>{2, 0}));
  const auto live = start();
  Page page = open(*live);
  page.write(asio::buffer(std::string("{\"rate\":0}")));
  live->publish(ReportClass::kHealth, "{}");
  read(page);
  EXPECT_EQ(read(page), "{}");
}

CameraImage small_image() {
  CameraImage image;
  image.readable = true;
  image.frame.width = 4;
  image.frame.height = 2;
  image.frame.pixels.resize(8);
  return image;
}

TEST_F(ViewServerTest, ProfilesGoToThePagesThatAsk) {
  const auto server = start();
  Page asking = open(*server), other = open(*server);
  read(asking);
  read(other);
  asking.write(asio::buffer(std::string(R"({"profiles":true})")));
  const CameraImage image = small_image();
  const SmallSweep small(3);
  const Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();
  const ImageMatch match{image, small.snapshot(), T_camera_lidar};
  std::jthread camera([&](std::stop_token stop) {
    for (; !stop.stop_requested(); std::this_thread::sleep_for(10ms)) {
      tap_.add_sweep(small.snapshot(), nullptr);  // what comes at once is not taken for a slow page
      tap_.add_image(match);
    }
  });
  std::vector<std::string> kinds;
  while (kinds.empty() || (kinds.back() != "profile" && kinds.size() < 100)) {
    kinds.push_back(Frame(read(asking)).header["kind"]);
  }
  EXPECT_EQ(kinds.back(), "profile");
  EXPECT_THAT(kinds, testing::Contains("image"));
  camera = {};
  // The other page gets sweeps and images, and nothing else before the next report.
  server->publish(ReportClass::kSweep, R"({"class":"SWEEP"})");
  std::string last;
  size_t frames = 0;
  for (; last.empty() || other.got_binary(); ++frames) {
    last = read(other);
    if (other.got_binary()) {
      EXPECT_THAT((std::vector<std::string>{"sweep", "image"}),
                  testing::Contains(Frame(last).header["kind"].get<std::string>()));
    }
  }
  EXPECT_GE(frames, 1u);
  EXPECT_EQ(last, R"({"class":"SWEEP"})");
}

TEST_F(ViewServerTest, AReplayThatHasEndedStillGivesAProfile) {
  std::atomic<bool> told = false;
  const auto server = start([&](const ViewCommand& command) {
    if (command.kind != ViewCommand::Kind::kOpened) told = true;
  });
  Page page = open(*server);
  read(page);
  page.write(
      asio::buffer(std::string(R"({"profiles":false})")));  // as a page says that has a panel
  page.write(asio::buffer(std::string(R"({"rate":1})")));
  EXPECT_TRUE(wait_until([&] { return told.load(); }));
  const CameraImage image = small_image();
  const SmallSweep small(3);
  const Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();
  // The first poll may come after the first image, which then has no returns.
  for (int images = 0; images < 2; ++images) {
    tap_.add_image({image, small.snapshot(), T_camera_lidar});
    EXPECT_EQ(Frame(read(page)).header["kind"], "image");
  }
  for (int times = 0; times < 2; ++times) {  // a panel that is opened again shows it again
    page.write(asio::buffer(std::string(R"({"profiles":true})")));
    EXPECT_EQ(Frame(read(page)).header["kind"], "profile");
  }
}

TEST_F(ViewServerTest, ATakenPortIsAnError) {
  const auto server = start();
  settings_.port = server->port();
  const auto second = ViewServer::start(settings_, small_rig(), {}, tap_, nullptr);
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().message().find(std::to_string(server->port())), std::string::npos);
}

}  // namespace
}  // namespace infuse::daemon
