#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <filesystem>

#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Lets the acceptor listen on a Unix stream socket that the owner and the group may use. A socket
/// that nobody answers on is taken over; the folder is made where it is missing. Where it fails the
/// acceptor is closed.
Result<void> listen_local(boost::asio::io_context& io,
                          boost::asio::local::stream_protocol::acceptor& acceptor,
                          const std::filesystem::path& path);

/// Lets the acceptor listen on the IPv4 loopback; `port` 0 takes a free one. Gives the port. Where
/// it fails the acceptor is closed.
Result<uint16_t> listen_loopback(boost::asio::ip::tcp::acceptor& acceptor, uint16_t port);

}  // namespace infuse::daemon
