#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <fstream>
#include <sstream>

#include "daemon/view/view_server.hpp"
#include "tests/folders.hpp"

namespace infuse::daemon {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

constexpr const char* kSecret = "0123456789abcdef-XY";

struct Attempt {
  std::string what;
  std::string request;
  std::string answer;  // status of HTTP, or "closed"
};

const std::string kHost = " HTTP/1.1\r\nHost: 127.0.0.1:1\r\n";

std::string get_request(const std::string& target, const std::string& more = "") {
  return "GET " + target + kHost + more + "\r\n";
}

std::string open_stream(const std::string& more) {
  return get_request("/stream",
                     more +
                         "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: "
                         "13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n");
}

std::vector<Attempt> attempts() {
  const std::string long_text(100'000, 'x');
  std::vector<Attempt> all;
  const auto add = [&](const char* what, const std::string& request, const char* answer) {
    all.push_back({what, request, answer});
  };
  add("write: POST /", "POST /" + kHost + "Content-Length: 0\r\n\r\n", "405");
  add("write: DELETE /stream", "DELETE /stream" + kHost + "\r\n", "405");
  add("a file of the host: GET /../../etc/passwd", get_request("/../../etc/passwd"), "404");
  add("the same, encoded: GET /%2e%2e/%2e%2e/etc/passwd", get_request("/%2e%2e/%2e%2e/etc/passwd"),
      "404");
  add("a target of 2000 characters", get_request("/" + long_text.substr(0, 2000)), "400");
  add("an absolute target, as to a proxy", get_request("http://127.0.0.1:1/"), "400");
  add("DNS rebinding: Host evil.example", "GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n", "403");
  add("DNS rebinding: Host localhost.evil.example",
      "GET / HTTP/1.1\r\nHost: localhost.evil.example:9468\r\n\r\n", "403");
  add("no Host", "GET / HTTP/1.1\r\n\r\n", "400");
  add("two Hosts", get_request("/", "Host: evil.example\r\n"), "400");
  add("a page of http://evil.example opens the stream",
      open_stream("Origin: http://evil.example\r\n"), "403");
  add("a page without an origin (null) opens the stream", open_stream("Origin: null\r\n"), "403");
  add("a page of another port of this host opens the stream",
      open_stream("Origin: http://127.0.0.1:2\r\n"), "403");
  add("a page of https at this address opens the stream",
      open_stream("Origin: https://127.0.0.1:1\r\n"), "403");
  add("the stream without a WebSocket", get_request("/stream"), "426");
  add("a header of 20 000 characters",
      get_request("/", "X: " + long_text.substr(0, 20'000) + "\r\n"), "closed");
  add("a body of 100 000 characters",
      "POST /" + kHost + "Content-Length: 100000\r\n\r\n" + long_text, "closed");
  add("TLS instead of HTTP", "\x16\x03\x01\x02\r\n\r\n", "closed");
  std::string zeros = "\r\n\r\n";
  zeros.insert(0, 100, '\0');
  add("100 zero bytes", zeros, "closed");
  return all;
}

std::vector<Attempt> attempts_at_a_token() {
  std::vector<Attempt> all;
  const auto add = [&](const char* what, const std::string& request, const char* answer) {
    all.push_back({what, request, answer});
  };
  add("with a token: the page without it", get_request("/"), "401");
  add("with a token: the page with the first half of it", get_request("/?token=0123456789"), "401");
  add("with a token: the stream without it", open_stream("Origin: http://127.0.0.1:1\r\n"), "401");
  add("with a token: the stream with a cookie of a like name",
      open_stream("Cookie: xinfuse_view=" + std::string(kSecret) + "\r\n"), "401");
  return all;
}

/// Status of the answer, or "closed".
std::string ask(const ViewServer& server, const std::string& request) {
  asio::io_context io;
  tcp::socket socket(io);
  socket.connect({asio::ip::make_address("127.0.0.1"), server.port()});
  boost::system::error_code ignored;
  asio::write(socket, asio::buffer(request), ignored);
  std::string answer;
  asio::read(socket, asio::dynamic_buffer(answer), ignored);
  return answer.size() > 12 ? answer.substr(9, 3) : "closed";
}

std::string documented() {
  std::ifstream file(source_folder() + "/daemon/view/security.md");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

void expect_answers(const ViewSettings& settings, const std::vector<Attempt>& attempts) {
  ViewTap tap(0);
  const auto server = ViewServer::start(settings, Rig{}, {}, tap, nullptr);
  ASSERT_TRUE(server) << server.error().message();
  const std::string page = settings.token.empty() ? "/" : std::string("/?token=") + settings.token;
  const std::string table = documented();
  for (const Attempt& attempt : attempts) {
    EXPECT_EQ(ask(**server, attempt.request), attempt.answer) << attempt.what;
    EXPECT_EQ(ask(**server, get_request(page)), "200") << "after: " << attempt.what;
    const std::string row = "| " + attempt.what + " | " + attempt.answer + " |\n";
    EXPECT_NE(table.find(row), std::string::npos) << row << " is not in daemon/view/security.md";
  }
}

TEST(ViewAttempts, AreAnsweredAsTheTableSays) { expect_answers({}, attempts()); }

TEST(ViewAttempts, AtATokenToo) {
  ViewSettings settings;
  settings.token = kSecret;
  expect_answers(settings, attempts_at_a_token());
}

TEST(ViewAttempts, TheTableHasNoOthers) {
  const std::string table = documented();
  size_t rows = 0;
  for (size_t at = 0; (at = table.find("\n| ", at)) != std::string::npos; ++at) ++rows;
  EXPECT_EQ(rows, 1 + attempts().size() + attempts_at_a_token().size());
}

}  // namespace
}  // namespace infuse::daemon
