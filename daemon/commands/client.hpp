#pragma once

#include <boost/asio/local/stream_protocol.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "daemon/protocol/counters_json.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// The other end of the daemon's socket.
class Client {
 public:
  /// Connects at `path`, or where it is empty, at the first default place where somebody answers,
  /// and takes the greeting.
  static Result<Client> connect(const std::filesystem::path& path);

  /// What the daemon said of itself.
  const Json& version() const { return version_; }

  /// Sends a request: `{"op":"poll"}`.
  Result<void> send(const Json& request);

  /// The next message; nothing when the daemon has ended. Waits for `patience` at most, or for
  /// ever.
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
