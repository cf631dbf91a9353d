#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <filesystem>

#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Lets the acceptor listen on a Unix stream socket with access for the owner and the group.
/// Replaces a socket on which nobody answers, and creates a missing folder. Closes the acceptor on
/// failure.
Result<void> listen_local(boost::asio::io_context& io,
                          boost::asio::local::stream_protocol::acceptor& acceptor,
                          const std::filesystem::path& path);

/// Lets the acceptor listen on the IPv4 loopback and returns the port; `port` 0 selects a free one.
/// Closes the acceptor on failure.
Result<uint16_t> listen_loopback(boost::asio::ip::tcp::acceptor& acceptor, uint16_t port);

}  // namespace infuse::daemon
