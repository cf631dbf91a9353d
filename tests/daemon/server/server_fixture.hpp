#pragma once

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
#include <thread>

#include "daemon/protocol/messages.hpp"
#include "tests/daemon/schema.hpp"
#include "tests/daemon/socket_client.hpp"

namespace infuse::daemon {

using nlohmann::json;

inline const std::vector<Device> kDevices = {
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

}  // namespace infuse::daemon
