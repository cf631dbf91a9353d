#include "daemon/server/server.hpp"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <boost/asio/write.hpp>

#include "daemon/protocol/messages.hpp"
#include "daemon/server/listening.hpp"
#include "daemon/server/peer.hpp"

namespace infuse::daemon {
namespace {

namespace asio = boost::asio;
using ErrorCode = boost::system::error_code;
using Local = asio::local::stream_protocol;

constexpr std::chrono::milliseconds kCheckPeriod{200};

}  // namespace

Server::Server(asio::io_context& io, const ServerOptions& options, std::string_view release,
               std::string_view session)
    : io_(io),
      options_(options),
      release_(release),
      session_(session),
      local_(io),
      tcp_(io),
      timer_(io) {
  set_configuration("", "");
  check_sessions();
}

Server::~Server() {
  for (const auto& session : sessions_) session->close();
  if (!path_.empty()) ::unlink(path_.c_str());
}

void Server::set_configuration(const std::string& digest, const std::string& version) {
  greeting_ = std::make_shared<const std::string>(
      message(VersionReport{release_, session_, digest, version}) + '\n');
}

Result<void> Server::listen(const std::filesystem::path& path) {
  if (auto listening = listen_local(io_, local_, path); !listening) return listening;
  path_ = path;
  accept(local_);
  return {};
}

Result<void> Server::adopt(int listening_socket) {
  ErrorCode error;
  local_.assign(Local(), listening_socket, error);
  if (error) return fail("cannot use the socket passed by systemd: " + error.message());
  accept(local_);
  return {};
}

Result<uint16_t> Server::listen_tcp(uint16_t port) {
  return listen_loopback(tcp_, port).map([this](uint16_t taken) {
    accept(tcp_);
    return taken;
  });
}

template <class Acceptor>
void Server::accept(Acceptor& acceptor) {
  acceptor.async_accept([this, &acceptor](ErrorCode error, auto socket) {
    if (error == asio::error::operation_aborted || !acceptor.is_open()) return;
    if (!error) {
      open_session(Session::Socket(std::move(socket)));
      accept(acceptor);
    } else {  // no free descriptor: it would fail again at once, so it waits for check_sessions()
      stalled_accepts_.emplace_back([this, &acceptor] { accept(acceptor); });
    }
  });
}

void Server::open_session(Session::Socket socket) {
  remove_closed();
  ClientUser client;
  if (const auto peer = peer_of(socket.native_handle())) {
    spdlog::debug("client connected: process {} of user {}", peer->process, peer->user);
    client = {peer->user, peer->user == ::geteuid() || peer->user == 0};
  }
  std::vector<ClientUser> connected;
  for (const auto& session : sessions_) connected.push_back(session->user());
  if (const auto refused = refuse_client(client, connected, options_)) {
    return reject(std::move(socket), *refused);
  }
  sessions_.push_back(std::make_shared<Session>(std::move(socket), options_, last_values_, control_,
                                                client, requests_of(client)));
  sessions_.back()->start(greeting_);
}

/// The same for all sessions of a user, also of those that come back at once.
std::shared_ptr<TokenBucket> Server::requests_of(const ClientUser& client) {
  std::shared_ptr<TokenBucket>& bucket = requests_[client.user];
  if (!bucket) {
    bucket = std::make_shared<TokenBucket>(options_.max_requests_hz, Session::Clock::now());
  }
  return bucket;
}

void Server::log_refusals() {
  if (const auto line = refusals_.due_line(Session::Clock::now())) spdlog::warn(*line);
}

void Server::reject(Session::Socket socket, const std::string& reason) {
  refusals_.add(reason);
  log_refusals();
  const ErrorReply reply{"", reason,
                         "close another client, or raise max_clients or max_clients_per_user in "
                         "[socket]"};
  ErrorCode ignored;
  socket.non_blocking(true, ignored);  // the buffer of a new socket has room for one line
  asio::write(socket, asio::buffer(message(reply) + '\n'), ignored);
}

void Server::publish(ReportClass report_class, const std::string& device, Stamp stamp,
                     std::string message) {
  message += '\n';
  const auto line = std::make_shared<const std::string>(std::move(message));
  for (const auto& session : sessions_) session->report(report_class, stamp, line);
  last_values_.set(report_class, device, line);
}

void Server::finish(std::chrono::milliseconds timeout) {
  ErrorCode ignored;
  local_.close(ignored);
  tcp_.close(ignored);
  for (const auto& session : sessions_) session->finish();
  finish_deadline_ = Session::Clock::now() + timeout;
  check_sessions();
}

void Server::remove_closed() {
  std::erase_if(sessions_, [](const auto& session) { return session->closed(); });
}

// Closes idle sessions, and all of them at the deadline of finish(); retries stalled accepts.
void Server::check_sessions() {
  const auto now = Session::Clock::now();
  for (const auto& session : sessions_) {
    const bool idle = now - session->last_activity() > options_.idle_timeout;
    if (idle || (finish_deadline_ && now >= *finish_deadline_)) session->close();
  }
  remove_closed();
  std::erase_if(requests_, [&](const auto& user) {
    return user.second.use_count() == 1 && user.second->full(now);
  });
  log_refusals();
  if (finish_deadline_ && sessions_.empty()) {
    timer_.cancel();
    return;
  }
  for (const auto& accept_again : std::exchange(stalled_accepts_, {})) accept_again();
  timer_.expires_after(finish_deadline_ ? kCheckPeriod / 10 : kCheckPeriod);
  timer_.async_wait([this](ErrorCode error) {
    if (!error) check_sessions();
  });
}

}  // namespace infuse::daemon
