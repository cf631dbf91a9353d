#pragma once

#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/beast/core/basic_stream.hpp>

namespace infuse::daemon {

/// A connection of a page or viewer, over TCP or a Unix socket.
using ViewStream = boost::beast::basic_stream<boost::asio::generic::stream_protocol>;

}  // namespace infuse::daemon
