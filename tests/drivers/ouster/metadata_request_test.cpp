// Metadata over HTTP, from a server of this test on the loopback.

#include "drivers/ouster/metadata_request.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>
#include <thread>

namespace infuse::ouster {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

/// Accepts one connection, reads a request and writes an answer, then closes, or holds the
/// connection until it is destroyed.
class OneAnswer {
 public:
  explicit OneAnswer(std::string answer, bool close = true)
      : answer_(std::move(answer)), close_(close) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    listener_ = socket(AF_INET, SOCK_STREAM, 0);
    socklen_t length = sizeof address;
    if (bind(listener_, reinterpret_cast<sockaddr*>(&address), length) != 0 ||
        listen(listener_, 1) != 0 ||
        getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &length) != 0) {
      throw std::runtime_error("no server on the loopback");
    }
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~OneAnswer() {
    shutdown(listener_, SHUT_RDWR);
    thread_.join();
    if (connection_ >= 0) ::close(connection_);
    ::close(listener_);
  }

  std::string host() const { return "127.0.0.1:" + std::to_string(port_); }
  /// What was asked. Call after the answer.
  const std::string& request() const { return request_; }

 private:
  void serve() {
    connection_ = accept(listener_, nullptr, nullptr);
    if (connection_ < 0) return;
    std::array<char, 4096> buffer;
    while (request_.find("\r\n\r\n") == std::string::npos) {
      const ssize_t n = recv(connection_, buffer.data(), buffer.size(), 0);
      if (n <= 0) return;
      request_.append(buffer.data(), static_cast<size_t>(n));
    }
    size_t sent = 0;
    while (sent < answer_.size()) {
      const ssize_t n =
          send(connection_, answer_.data() + sent, answer_.size() - sent, MSG_NOSIGNAL);
      if (n <= 0) return;
      sent += static_cast<size_t>(n);
    }
    if (close_) shutdown(connection_, SHUT_WR);
  }

  std::string answer_;
  bool close_;
  int listener_ = -1, connection_ = -1;
  uint16_t port_ = 0;
  std::string request_;
  std::thread thread_;
};

std::string request_error(const std::string& host) {
  const auto text = request_metadata(host, 500ms);
  return text ? "answered" : text.error().message();
}

TEST(OusterMetadataRequest, AsksForTheMetadata) {
  OneAnswer server("HTTP/1.1 200 OK\r\nContent-Length: 13\r\n\r\n{\"status\": 1}");
  const auto text = request_metadata(server.host(), 5s);
  ASSERT_TRUE(text) << text.error().message();
  EXPECT_EQ(*text, "{\"status\": 1}");
  EXPECT_THAT(server.request(), testing::StartsWith("GET /api/v1/sensor/metadata HTTP/1.1\r\n"));
  EXPECT_THAT(server.request(), HasSubstr("Host: 127.0.0.1\r\n"));
}

TEST(OusterMetadataRequest, ReadsAnAnswerInChunksAndOneThatEndsWithTheConnection) {
  OneAnswer chunks(
      "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n3\r\n{\"a\r\n4\r\n\":1}\r\n0\r\n\r\n");
  EXPECT_EQ(request_metadata(chunks.host(), 5s).value(), "{\"a\":1}");
  OneAnswer until_closed("HTTP/1.1 200 OK\r\n\r\n{\"b\":2}");
  EXPECT_EQ(request_metadata(until_closed.host(), 5s).value(), "{\"b\":2}");
}

TEST(OusterMetadataRequest, SaysWhyThereIsNone) {
  OneAnswer silent("", false);
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THAT(request_error(silent.host()), HasSubstr("no answer in time"));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s);

  OneAnswer not_found("HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n");
  EXPECT_THAT(request_error(not_found.host()), HasSubstr("answers with status 404"));
  OneAnswer no_http("SSH-2.0-OpenSSH\r\n");
  EXPECT_THAT(request_error(no_http.host()), HasSubstr("cannot be read"));
  OneAnswer endless("HTTP/1.1 200 OK\r\nContent-Length: 2000000\r\n\r\n");
  EXPECT_THAT(request_error(endless.host()), HasSubstr("cannot be read"));
  OneAnswer large("HTTP/1.1 200 OK\r\n\r\n" + std::string(3'000'000, ' '));
  EXPECT_THAT(request_error(large.host()), HasSubstr("cannot be read"));
  EXPECT_THAT(request_error("127.0.0.1:1"), HasSubstr("http://127.0.0.1:1/api/v1/sensor/metadata"));
  EXPECT_THAT(request_error("127.0.0.1:http%"), HasSubstr("cannot be read"));
}

}  // namespace
}  // namespace infuse::ouster
