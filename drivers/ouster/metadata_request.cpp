#include "drivers/ouster/metadata_request.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>

namespace infuse::ouster {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using boost::system::error_code;

constexpr const char* kTarget = "/api/v1/sensor/metadata";
constexpr size_t kMaxBodyBytes = 1 << 20;
constexpr const char* kHint =
    "is the sensor on, and in this network? Its metadata can also be stored in a file, which "
    "calibration names";

/// One request and its answer, with one deadline for all of it.
class MetadataRequest {
 public:
  MetadataRequest(const std::string& host, const std::string& port) : host_(host), port_(port) {
    request_.version(11);
    request_.method(http::verb::get);
    request_.target(kTarget);
    request_.set(http::field::host, host);
    request_.set(http::field::connection, "close");
    response_.body_limit(kMaxBodyBytes);
  }

  /// Runs until the answer has arrived or the time is over.
  error_code run(std::chrono::milliseconds timeout) {
    asio::ip::tcp::resolver resolver(context_);
    const auto endpoints = resolver.resolve(host_, port_, error_);
    if (error_) return error_;
    stream_.expires_after(timeout);
    stream_.async_connect(endpoints, [this](error_code error, const auto&) { on_connect(error); });
    context_.run();
    return error_;
  }

  const http::response<http::string_body>& response() const { return response_.get(); }

 private:
  void on_connect(error_code error) {
    error_ = error;
    if (error) return;
    http::async_write(stream_, request_, [this](error_code failed, size_t) { on_write(failed); });
  }

  void on_write(error_code error) {
    error_ = error;
    if (error) return;
    http::async_read(stream_, buffer_, response_,
                     [this](error_code failed, size_t) { error_ = failed; });
  }

  std::string host_, port_;
  asio::io_context context_;
  beast::tcp_stream stream_{context_};
  http::request<http::empty_body> request_;
  http::response_parser<http::string_body> response_;
  beast::flat_buffer buffer_;
  error_code error_;
};

}  // namespace

Result<std::string> request_metadata(const std::string& host, std::chrono::milliseconds timeout) {
  const size_t colon = host.rfind(':');
  const std::string name = host.substr(0, colon);
  const std::string port = colon == std::string::npos ? "80" : host.substr(colon + 1);
  const std::string where = "http://" + host + kTarget;
  MetadataRequest request(name, port);
  const error_code error = request.run(timeout);
  if (error == beast::error::timeout) return fail("no answer in time", where, kHint);
  if (error) return fail("cannot be read: " + error.message(), where, kHint);
  if (request.response().result() != http::status::ok) {
    return fail("answers with status " + std::to_string(request.response().result_int()), where,
                "firmware before 2.2 has no such address: store the metadata in a file");
  }
  return request.response().body();
}

}  // namespace infuse::ouster
