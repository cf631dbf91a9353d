#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <functional>

namespace infuse::daemon {

/// Wakes an `io_context` from another thread without allocating (an eventfd).
class Notifier {
 public:
  /// `callback` is called on the thread of `io` after each `notify`; several may cause one call.
  Notifier(boost::asio::io_context& io, std::function<void()> callback);

  /// Causes a call; from any thread.
  void notify();

  /// Ends the calls.
  void close();

 private:
  void listen();

  boost::asio::posix::stream_descriptor event_;
  std::function<void()> callback_;
  uint64_t notifications_ = 0;
};

}  // namespace infuse::daemon
