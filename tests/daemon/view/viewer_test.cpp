#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <cstring>
#include <thread>

#include "daemon/protocol/json.hpp"
#include "daemon/view/foxglove_protocol.hpp"
#include "daemon/view/view_server.hpp"
#include "drivers/ros/messages.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

namespace infuse::daemon {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using namespace std::chrono_literals;

TEST(FoxgloveProtocol, TheNewerSubprotocolIsChosen) {
  EXPECT_EQ(choose_subprotocol("foxglove.websocket.v1"), "foxglove.websocket.v1");
  EXPECT_EQ(choose_subprotocol("foxglove.websocket.v1, foxglove.sdk.v1"), "foxglove.sdk.v1");
  EXPECT_EQ(choose_subprotocol(" foxglove.sdk.v1 "), "foxglove.sdk.v1");
  EXPECT_EQ(choose_subprotocol(""), "");
  EXPECT_EQ(choose_subprotocol("foxglove.websocket.v10,mqtt"), "");
}

TEST(FoxgloveProtocol, OnlySubscriptionsAreRead) {
  const auto both = parse_viewer_request(
      R"({"op":"subscribe","subscriptions":[{"id":7,"channelId":2},{"id":4294967295,"channelId":0}]})");
  EXPECT_EQ(both.refused, "");
  ASSERT_EQ(both.subscribe.size(), 2u);
  EXPECT_EQ(both.subscribe[0], (ViewerRequest::Subscription{7, 2}));
  EXPECT_EQ(both.subscribe[1].id, 4294967295u);
  EXPECT_EQ(parse_viewer_request(R"({"op":"unsubscribe","subscriptionIds":[7]})").unsubscribe,
            std::vector<uint32_t>{7});
  for (const char* text :
       {"", "[]", "{", "{\"op\":\"subscribe\"}", R"({"op":"subscribe","subscriptions":[1]})",
        R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":0}]})",
        R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":0}]})",
        R"({"op":"subscribe","subscriptions":[{"id":"1","channelId":0}]})",
        R"({"op":"unsubscribe","subscriptionIds":7})", R"({"op":"setParameters"})",
        R"({"op":"advertise","channels":[]})", R"({"op":7})"}) {
    const auto request = parse_viewer_request(text);
    EXPECT_NE(request.refused, "") << text;
    EXPECT_TRUE(request.subscribe.empty() && request.unsubscribe.empty()) << text;
  }
}

MessageSetup setup(bool live) {
  MessageSetup messages{.live = live};
  messages.rig.lidars = {LidarMount{.name = "top"}};
  messages.packet_makers = {&velodyne::maker()};
  messages.packet_metadata = {""};
  messages.has_motion = true;
  return messages;
}

class ViewerTest : public testing::Test {
 protected:
  using Socket = websocket::stream<tcp::socket>;

  void start(bool live = true) {
    channels_ = std::make_unique<ViewerChannels>(setup(live));
    Rig rig;
    auto server = ViewServer::start(settings_, rig, {}, tap_, nullptr, channels_.get());
    ASSERT_TRUE(server) << server.error().message();
    server_ = *std::move(server);
  }
  void TearDown() override { server_.reset(); }

  Socket open(const std::string& protocol, beast::error_code& error, const std::string& origin = {},
              const std::string& target = "/") {
    tcp::socket socket(io_);
    socket.connect({asio::ip::make_address("127.0.0.1"), server_->port()});
    Socket viewer(std::move(socket));
    viewer.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
      request.set(beast::http::field::sec_websocket_protocol, protocol);
      if (!origin.empty()) request.set(beast::http::field::origin, origin);
    }));
    websocket::response_type response;
    viewer.handshake(response, "127.0.0.1:" + std::to_string(server_->port()), target, error);
    chosen_ = std::string(response[beast::http::field::sec_websocket_protocol]);
    return viewer;
  }

  /// An open viewer that has read the greeting; fills `channels` with the ids by topic.
  Socket greeted(const std::string& protocol = "foxglove.sdk.v1") {
    beast::error_code error;
    Socket viewer = open(protocol, error);
    EXPECT_FALSE(error) << error.message();
    info_ = Json::parse(read(viewer));
    const Json advertised = Json::parse(read(viewer));
    EXPECT_EQ(advertised["op"], "advertise");
    for (const auto& channel : advertised["channels"]) channel_[channel["topic"]] = channel;
    return viewer;
  }

  static std::string read(Socket& viewer) {
    beast::flat_buffer buffer;
    viewer.read(buffer);
    return beast::buffers_to_string(buffer.data());
  }
  static void write(Socket& viewer, const std::string& text) {
    viewer.text(true);
    viewer.write(asio::buffer(text));
  }
  void subscribe(Socket& viewer, uint32_t id, const std::string& topic) {
    write(viewer, json_text({{"op", "subscribe"},
                             {"subscriptions",
                              Json::array({{{"id", id}, {"channelId", channel_[topic]["id"]}}})}}));
  }
  static bool wait_until(const std::function<bool()>& condition) {
    for (int k = 0; k < 1000 && !condition(); ++k) std::this_thread::sleep_for(10ms);
    return condition();
  }
  void add_imu(double wz, int64_t ns) {
    ros::Imu imu;
    imu.angular_velocity.z = wz;
    channels_->write("/vehicle/imu", Stamp::from_ns(ns), imu);
  }

  ViewSettings settings_;  // port 0: any free one
  ViewTap tap_{0};
  asio::io_context io_;
  std::unique_ptr<ViewerChannels> channels_;
  std::unique_ptr<ViewServer> server_;
  std::string chosen_;
  Json info_;
  std::map<std::string, Json> channel_;
};

TEST_F(ViewerTest, SpeaksBothSubprotocolsAndAdvertisesEveryTopicWithItsSchema) {
  start();
  for (const char* protocol : {"foxglove.sdk.v1", "foxglove.websocket.v1"}) {
    Socket viewer = greeted(protocol);
    EXPECT_EQ(chosen_, protocol);
    EXPECT_EQ(info_["op"], "serverInfo");
    EXPECT_EQ(info_["capabilities"], Json::array());
    for (const char* topic : {"/lidar/top/packets", "/lidar/top/points", "/lidar/top/points_raw",
                              "/vehicle/imu", "/tf_static", "/odometry/odom", "/diagnostics"}) {
      ASSERT_TRUE(channel_.contains(topic)) << topic;
      EXPECT_EQ(channel_[topic]["encoding"], "cdr");
      EXPECT_EQ(channel_[topic]["schemaEncoding"], "ros2msg");
      EXPECT_FALSE(channel_[topic]["schema"].get<std::string>().empty());
    }
    EXPECT_EQ(channel_["/vehicle/imu"]["schemaName"], "sensor_msgs/msg/Imu");
  }
  EXPECT_EQ(tap_.wanted(), false);  // viewers do not cost what pages do
}

TEST_F(ViewerTest, MessagesComeToThoseWhoHaveSubscribed) {
  start();
  EXPECT_FALSE(channels_->wanted());
  EXPECT_FALSE(channels_->wants("/vehicle/imu"));
  Socket viewer = greeted();
  subscribe(viewer, 42, "/vehicle/imu");
  ASSERT_TRUE(wait_until([&] { return channels_->wants("/vehicle/imu"); }));
  EXPECT_FALSE(channels_->wants("/vehicle/twist"));
  add_imu(0.5, 1'700'000'000'000'000'001);
  const std::string message = read(viewer);
  EXPECT_TRUE(viewer.got_binary());
  ASSERT_GT(message.size(), 13u);
  EXPECT_EQ(message[0], 1);
  uint32_t id = 0;
  uint64_t time = 0;
  std::memcpy(&id, message.data() + 1, sizeof id);
  std::memcpy(&time, message.data() + 5, sizeof time);
  EXPECT_EQ(id, 42u);
  EXPECT_EQ(time, 1'700'000'000'000'000'001u);
  const auto imu = ros::decode<ros::Imu>(
      {reinterpret_cast<const uint8_t*>(message.data()) + 13, message.size() - 13},
      ros::Encoding::kCdr);
  ASSERT_TRUE(imu);
  EXPECT_EQ(imu->angular_velocity.z, 0.5);
  write(viewer, R"({"op":"unsubscribe","subscriptionIds":[42]})");
  EXPECT_TRUE(wait_until([&] { return !channels_->wanted(); }));
  subscribe(viewer, 43, "/vehicle/imu");
  ASSERT_TRUE(wait_until([&] { return channels_->wanted(); }));
  viewer.next_layer().close();  // without a word
  EXPECT_TRUE(wait_until([&] { return !channels_->wanted(); }));
}

TEST_F(ViewerTest, LatchedTransformsComeToLateViewers) {
  start();
  EXPECT_TRUE(channels_->wants("/tf_static"));
  channels_->write("/tf_static", Stamp::from_ns(5), ros::TfMessage{{{}}}, true);
  Socket viewer = greeted();
  subscribe(viewer, 1, "/tf_static");
  const std::string message = read(viewer);
  EXPECT_TRUE(viewer.got_binary());
  EXPECT_EQ(message[0], 1);
}

TEST_F(ViewerTest, AReplaySendsItsTime) {
  start(false);
  Socket viewer = greeted();
  EXPECT_EQ(info_["capabilities"], Json::array({"time"}));
  subscribe(viewer, 1, "/vehicle/imu");
  ASSERT_TRUE(wait_until([&] { return channels_->wanted(); }));
  add_imu(0, 77'000'000'000);
  const std::string time = read(viewer);
  ASSERT_EQ(time.size(), 9u);
  EXPECT_EQ(time[0], 2);
  uint64_t ns = 0;
  std::memcpy(&ns, time.data() + 1, sizeof ns);
  EXPECT_EQ(ns, 77'000'000'000u);
  EXPECT_EQ(read(viewer)[0], 1);
}

TEST_F(ViewerTest, WhatIsNoSubscriptionIsRefusedAndTheViewerLives) {
  start();
  Socket viewer = greeted();
  for (const char* text : {R"({"op":"setParameters","parameters":[]})", "nonsense",
                           R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":999}]})"}) {
    write(viewer, text);
    const Json status = Json::parse(read(viewer));
    EXPECT_EQ(status["op"], "status") << text;
  }
  viewer.binary(true);
  viewer.write(asio::buffer(std::string("\x01\0\0\0\0data", 9)));
  EXPECT_EQ(Json::parse(read(viewer))["level"], 2);
  subscribe(viewer, 1, "/vehicle/imu");
  subscribe(viewer, 1, "/vehicle/twist");  // the same id again
  EXPECT_EQ(Json::parse(read(viewer))["level"], 1);
  EXPECT_TRUE(channels_->wants("/vehicle/imu"));
  EXPECT_FALSE(channels_->wants("/vehicle/twist"));
}

TEST_F(ViewerTest, OriginsAndTheTokenAreThoseOfTheView) {
  settings_.token = "0123456789abcdef";
  settings_.allowed_origins = {"https://app.foxglove.dev"};
  start();
  const auto opens = [&](const std::string& origin, const std::string& target) {
    beast::error_code error;
    open("foxglove.sdk.v1", error, origin, target);
    return !error;
  };
  const std::string token = "/?token=0123456789abcdef";
  EXPECT_TRUE(opens("", token));
  EXPECT_TRUE(opens("https://app.foxglove.dev", token));
  EXPECT_FALSE(opens("https://app.foxglove.dev", "/"));
  EXPECT_FALSE(opens("https://evil.example", token));
  EXPECT_FALSE(opens("null", token));
}

TEST_F(ViewerTest, ViewersCountAsPages) {
  settings_.max_clients = 1;
  start();
  Socket one = greeted();
  beast::error_code error;
  open("foxglove.sdk.v1", error);
  EXPECT_TRUE(error);
}

TEST_F(ViewerTest, ASlowViewerLosesMessagesAndIsTold) {
  start();
  Socket viewer = greeted();
  subscribe(viewer, 1, "/lidar/top/points");
  ASSERT_TRUE(wait_until([&] { return channels_->wanted(); }));
  const std::vector<uint8_t> cloud(1 << 20, 7);
  constexpr int kSent = 200;  // MiB: beyond what sockets and queues hold
  for (int k = 0; k < kSent; ++k)
    channels_->add("/lidar/top/points", "", Stamp::from_ns(1), false, cloud);
  int got = 0;
  std::string text;
  while (text.empty()) {
    const std::string message = read(viewer);
    if (viewer.got_binary()) {
      ++got;
    } else {
      text = message;
    }
  }
  const Json status = Json::parse(text);
  EXPECT_EQ(status["op"], "status");
  const int lost = std::stoi(status["message"].get<std::string>());
  EXPECT_GT(lost, 0);
  EXPECT_GT(got, 0);
  EXPECT_LE(got + lost, kSent);
}

}  // namespace
}  // namespace infuse::daemon
