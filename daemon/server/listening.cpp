#include "daemon/server/listening.hpp"

#include <sys/stat.h>
#include <unistd.h>

namespace infuse::daemon {
namespace {

namespace asio = boost::asio;
using ErrorCode = boost::system::error_code;
using Local = asio::local::stream_protocol;

bool is_answered(asio::io_context& io, const Local::endpoint& endpoint) {
  Local::socket probe(io);
  ErrorCode error;
  probe.connect(endpoint, error);
  return !error;
}

/// Binds with access for the owner and the group only.
void bind_for_group(Local::acceptor& acceptor, const Local::endpoint& endpoint, ErrorCode& error) {
  const mode_t before = umask(0117);
  acceptor.bind(endpoint, error);
  umask(before);
}

}  // namespace

Result<void> listen_local(asio::io_context& io, Local::acceptor& acceptor,
                          const std::filesystem::path& path) {
  const char* hint = "choose another path";
  const auto failed = [&](const std::string& what, const ErrorCode& error) {
    ErrorCode ignored;
    acceptor.close(ignored);
    return fail(what + ": " + error.message(), path.string(), hint);
  };
  if (path.string().size() >= sizeof(sockaddr_un::sun_path)) {
    return fail("socket path longer than 107 bytes", path.string(), hint);
  }
  const Local::endpoint endpoint(path.string());
  if (is_answered(io, endpoint)) {
    return fail("another infused is listening on this socket", path.string(), hint);
  }
  std::error_code folder_error;
  std::filesystem::create_directories(path.parent_path(), folder_error);
  if (std::filesystem::is_socket(std::filesystem::symlink_status(path, folder_error))) {
    ::unlink(path.c_str());  // left behind by a killed daemon
  }
  ErrorCode error;
  acceptor.open(endpoint.protocol(), error);
  if (error) return failed("cannot create a socket", error);
  bind_for_group(acceptor, endpoint, error);
  if (error) return failed("cannot bind the socket", error);
  acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) return failed("cannot listen on the socket", error);
  return {};
}

Result<uint16_t> listen_loopback(asio::ip::tcp::acceptor& acceptor, uint16_t port) {
  const asio::ip::tcp::endpoint endpoint(asio::ip::address_v4::loopback(), port);
  ErrorCode error;
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) {
    ErrorCode ignored;
    acceptor.close(ignored);
    return fail("cannot listen: " + error.message(), "127.0.0.1:" + std::to_string(port),
                "choose another port");
  }
  return acceptor.local_endpoint(error).port();
}

}  // namespace infuse::daemon
