// Against Debian's mosquitto, on the loopback; skipped where it is not installed.
#include "daemon/mqtt/mqtt_publisher.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <mosquitto.h>
#include <netinet/in.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <functional>
#include <thread>
#include <utility>
#include <vector>

#include "daemon/mqtt/mqtt_client.hpp"
#include "daemon/mqtt/report_topics.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

using std::chrono::milliseconds;
using namespace std::chrono_literals;

constexpr const char* kBroker = "/usr/sbin/mosquitto";

bool wait_until(const std::function<bool()>& condition, milliseconds limit = 20s) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(20ms);
  }
  return true;
}

uint16_t free_port() {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof(address);
  ::bind(socket, reinterpret_cast<sockaddr*>(&address), length);
  ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &length);
  ::close(socket);
  return ntohs(address.sin_port);
}

class Broker {
 public:
  explicit Broker(uint16_t port, const std::string& more = "") {
    folder_.write("broker.conf", "listener " + std::to_string(port) + " 127.0.0.1\n" +
                                     (more.empty() ? "allow_anonymous true\n" : more));
    const std::string config = (folder_ / "broker.conf").string();
    const char* arguments[] = {kBroker, "-c", config.c_str(), nullptr};
    posix_spawn_file_actions_t quiet;
    posix_spawn_file_actions_init(&quiet);
    posix_spawn_file_actions_addopen(&quiet, 2, "/dev/null", O_WRONLY, 0);
    ::posix_spawn(&process_, kBroker, &quiet, nullptr, const_cast<char**>(arguments), environ);
    posix_spawn_file_actions_destroy(&quiet);
  }
  ~Broker() {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }

 private:
  ScratchFolder folder_;
  pid_t process_ = 0;
};

/// Everything that the broker has or gets, by another use of the library.
class Subscriber {
 public:
  explicit Subscriber(uint16_t port) {
    client_ = mosquitto_new("subscriber", true, this);
    mosquitto_message_callback_set(
        client_, [](mosquitto*, void* self, const mosquitto_message* message) {
          static_cast<Subscriber*>(self)->messages.emplace_back(
              message->topic, std::string(static_cast<const char*>(message->payload),
                                          static_cast<size_t>(message->payloadlen)));
        });
    wait_until(
        [&] { return mosquitto_connect(client_, "127.0.0.1", port, 30) == MOSQ_ERR_SUCCESS; });
    mosquitto_subscribe(client_, nullptr, "#", 1);
  }
  ~Subscriber() { mosquitto_destroy(client_); }

  bool wait_for(const std::function<bool()>& condition) {
    return wait_until([&] {
      mosquitto_loop(client_, 20, 1);
      return condition();
    });
  }

  /// Payloads of a topic, each once, in the order of their first arrival.
  std::vector<std::string> payloads(const std::string& topic) const {
    std::vector<std::string> out;
    for (const auto& [name, payload] : messages) {
      if (name == topic && std::find(out.begin(), out.end(), payload) == out.end()) {
        out.push_back(payload);
      }
    }
    return out;
  }

  std::vector<std::pair<std::string, std::string>> messages;

 private:
  mosquitto* client_;
};

class MqttPublisherTest : public testing::Test {
 protected:
  void SetUp() override {
    if (::access(kBroker, X_OK) != 0) GTEST_SKIP() << kBroker << " is not installed";
    mosquitto_lib_init();
    settings_.port = free_port();
  }

  std::unique_ptr<MqttPublisher> start() {
    auto started = MqttPublisher::start(settings_, folder_ / "mqtt.db", "0.1.0");
    EXPECT_TRUE(started) << started.error().message();
    return started ? *std::move(started) : nullptr;
  }

  void add(MqttPublisher& publisher, int from, int to) {
    for (int k = from; k < to; ++k) {
      publisher.add({.topic = kTopic, .payload = std::to_string(k)});
      expected_.push_back(std::to_string(k));
      std::this_thread::sleep_for(5ms);
    }
  }

  static constexpr const char* kTopic = "infuse/car7/health";
  ScratchFolder folder_;
  MqttSettings settings_{.host = "127.0.0.1", .vehicle = "car7"};
  std::vector<std::string> expected_;
};

TEST_F(MqttPublisherTest, ReportsArriveInOrderAndTheStatusIsKept) {
  const Broker broker(settings_.port);
  Subscriber subscriber(settings_.port);
  const auto publisher = start();
  ASSERT_TRUE(publisher);
  add(*publisher, 0, 100);
  EXPECT_TRUE(subscriber.wait_for([&] { return subscriber.payloads(kTopic).size() == 100; }));
  EXPECT_EQ(subscriber.payloads(kTopic), expected_);
  EXPECT_TRUE(wait_until([&] { return publisher->stats().depth == 0; }));
  publisher->finish(5s);
  EXPECT_TRUE(subscriber.wait_for(
      [&] { return subscriber.payloads(status_topic(settings_)).size() == 2; }));
  EXPECT_EQ(subscriber.payloads(status_topic(settings_)),
            (std::vector<std::string>{R"({"online":true,"release":"0.1.0","dropped":0})",
                                      R"({"online":false,"release":"0.1.0","dropped":0})"}));
  Subscriber later(settings_.port);
  EXPECT_TRUE(later.wait_for([&] { return !later.messages.empty(); }));
  EXPECT_EQ(later.messages.front().first, status_topic(settings_));
}

TEST_F(MqttPublisherTest, NothingIsLostWithoutABrokerAndWhenItIsKilled) {
  auto publisher = start();
  ASSERT_TRUE(publisher);
  add(*publisher, 0, 50);  // no broker yet
  {
    const Broker broker(settings_.port);
    Subscriber subscriber(settings_.port);
    ASSERT_TRUE(subscriber.wait_for([&] { return subscriber.payloads(kTopic).size() == 50; }));
    EXPECT_EQ(subscriber.payloads(kTopic), expected_);
    EXPECT_TRUE(wait_until([&] { return publisher->stats().depth == 0; }));
  }  // killed
  expected_.clear();
  add(*publisher, 50, 80);
  publisher.reset();  // the vehicle is switched off, and on again
  publisher = start();
  ASSERT_TRUE(publisher);
  add(*publisher, 80, 100);
  const Broker broker(settings_.port);
  Subscriber subscriber(settings_.port);
  EXPECT_TRUE(subscriber.wait_for([&] { return subscriber.payloads(kTopic).size() == 50; }));
  EXPECT_EQ(subscriber.payloads(kTopic), expected_);
  EXPECT_EQ(publisher->stats().lost, 0u);
}

TEST_F(MqttPublisherTest, ALostVehicleIsOffline) {
  const Broker broker(settings_.port);
  Subscriber subscriber(settings_.port);
  {
    MqttClient client(settings_, "", {status_topic(settings_), "lost"}, [](int) {});
    ASSERT_TRUE(client.connect());
    ASSERT_TRUE(wait_until([&] { return client.run(10ms) && client.connected(); }));
  }  // without a word
  EXPECT_TRUE(subscriber.wait_for([&] { return !subscriber.messages.empty(); }));
  EXPECT_EQ(subscriber.messages.front(), std::pair(status_topic(settings_), std::string("lost")));
}

TEST_F(MqttPublisherTest, ARefusalIsNamed) {
  const Broker broker(settings_.port, "allow_anonymous false\n");
  MqttClient client(settings_, "", {"t", "lost"}, [](int) {});
  std::string why;
  ASSERT_TRUE(wait_until([&] {
    if (!client.connect()) return false;
    for (int k = 0; k < 100; ++k) {
      if (const auto alive = client.run(10ms); !alive) {
        why = alive.error().message();
        return why.find("refuses") != std::string::npos;
      }
    }
    return false;
  })) << why;
  EXPECT_NE(why.find("ot authori"), std::string::npos) << why;
}

TEST(MqttPublisher, APasswordThatCannotBeReadIsNamed) {
  const MqttSettings settings{
      .host = "127.0.0.1", .vehicle = "car7", .password_file = "/nonexistent/password"};
  const auto started = MqttPublisher::start(settings, "", "0.1.0");
  ASSERT_FALSE(started);
  EXPECT_NE(started.error().message().find("/nonexistent/password"), std::string::npos);
}

TEST(MqttPublisher, ABrokerThatDoesNotAnswerHoldsNothingUp) {
  const int silent = ::socket(AF_INET, SOCK_STREAM, 0);  // nobody accepts here
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof(address);
  ASSERT_EQ(::bind(silent, reinterpret_cast<sockaddr*>(&address), length), 0);
  ASSERT_EQ(::listen(silent, 0), 0);
  ::getsockname(silent, reinterpret_cast<sockaddr*>(&address), &length);
  std::vector<int> filling;  // the backlog
  for (int k = 0; k < 4; ++k) {
    filling.push_back(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0));
    static_cast<void>(::connect(filling.back(), reinterpret_cast<sockaddr*>(&address), length));
  }
  const ScratchFolder folder;
  const MqttSettings settings{
      .host = "127.0.0.1", .port = ntohs(address.sin_port), .vehicle = "car7"};
  {
    const auto started = MqttPublisher::start(settings, folder / "mqtt.db", "0.1.0");
    ASSERT_TRUE(started) << started.error().message();
    std::this_thread::sleep_for(300ms);
    for (int k = 0; k < 100; ++k) (*started)->add({.topic = "t", .payload = "x"});
    (*started)->finish(200ms);
  }
  for (const int one : filling) ::close(one);
  ::close(silent);
  EXPECT_EQ(ReportQueue(folder / "mqtt.db", 1 << 20).messages(), 100u);
}

TEST(MqttPublisher, WithoutABrokerNobodyWaits) {
  MqttSettings settings{.host = "127.0.0.1", .port = 1, .vehicle = "car7"};
  const auto started = MqttPublisher::start(settings, "", "0.1.0");
  ASSERT_TRUE(started) << started.error().message();
  const auto begin = std::chrono::steady_clock::now();
  for (int k = 0; k < 5000; ++k) (*started)->add({.topic = "t", .payload = "x"});
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s);
  (*started)->finish(1s);
  const QueueStats stats = (*started)->stats();
  EXPECT_EQ(std::string(stats.name), "mqtt_kib");
  EXPECT_EQ(stats.capacity, 64u * 1024);
}

}  // namespace
}  // namespace infuse::daemon
