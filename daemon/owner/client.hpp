#pragma once

#include <boost/asio/local/stream_protocol.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "daemon/protocol/json.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// A client of the daemon's socket.
class Client {
 public:
  /// Connects to `path`, or if it is empty, to the first default path that answers, and reads the
  /// greeting.
  static Result<Client> connect(const std::filesystem::path& path);

  /// The daemon's greeting.
  const Json& version() const { return version_; }

  /// Sends a request: `{"op":"poll"}`.
  Result<void> send(const Json& request);

  /// Returns the next message; nothing when the daemon has ended. Waits at most for `timeout`, or
  /// without limit.
  Result<std::optional<Json>> next(std::optional<std::chrono::seconds> timeout);

 private:
  using Stream = boost::asio::local::stream_protocol::iostream;
  Client(std::unique_ptr<Stream> stream, std::string path)
      : stream_(std::move(stream)), path_(std::move(path)) {}

  std::unique_ptr<Stream> stream_;
  std::string path_;
  Json version_;
};

}  // namespace infuse::daemon
