#include "daemon/owner/client.hpp"

#include "daemon/server/socket_path.hpp"

namespace infuse::daemon {
namespace {

constexpr std::chrono::seconds kReplyTimeout{5};

}  // namespace

Result<Client> Client::connect(const std::filesystem::path& path) {
  const auto paths = path.empty() ? default_socket_paths() : std::vector{path};
  std::string tried;
  for (const std::filesystem::path& candidate : paths) {
    tried += (tried.empty() ? "" : ", ") + candidate.string();
    auto stream = std::make_unique<Stream>();
    stream->connect(boost::asio::local::stream_protocol::endpoint(candidate.string()));
    if (stream->error() == boost::asio::error::access_denied) {
      return fail("no permission to open the socket", candidate.string(),
                  "join the group that owns it (usermod -aG infuse NAME), and log in again");
    }
    if (!*stream) continue;
    Client client(std::move(stream), candidate.string());
    auto greeting = client.next(kReplyTimeout);
    if (!greeting) return tl::unexpected(greeting.error());
    if (!*greeting || (*greeting)->value("class", "") != "VERSION") {
      return fail(*greeting ? (*greeting)->value("what", "no greeting from infused")
                            : "the daemon closed the connection",
                  candidate.string());
    }
    client.version_ = **greeting;
    return client;
  }
  return fail("no daemon answers", tried, "is infused running? give its socket with --socket");
}

Result<void> Client::send(const Json& request) {
  *stream_ << json_text(request) << '\n' << std::flush;
  if (!*stream_) return fail("the daemon closed the connection", path_);
  return {};
}

Result<std::optional<Json>> Client::next(std::optional<std::chrono::seconds> timeout) {
  if (timeout) {
    stream_->expires_after(*timeout);
  } else {
    stream_->expires_at(std::chrono::steady_clock::time_point::max());
  }
  std::string line;
  if (!std::getline(*stream_, line)) {
    if (stream_->error() == boost::asio::error::operation_aborted) {
      return fail("the daemon does not answer", path_);
    }
    return std::optional<Json>();
  }
  Json message = Json::parse(line, nullptr, false);
  if (!message.is_object()) return fail("not a message of infused: " + line, path_);
  return std::optional<Json>(std::move(message));
}

}  // namespace infuse::daemon
