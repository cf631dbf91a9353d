#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <functional>

namespace infuse::daemon {

/// Lets a thread wake an `io_context` without allocating (an eventfd).
class Notifier {
 public:
  /// `answer` is called on the thread of `io` some time after each `ring`; several may be answered
  /// once.
  Notifier(boost::asio::io_context& io, std::function<void()> callback);

  /// From any thread.
  void notify();

  /// Answers no more.
  void close();

 private:
  void listen();

  boost::asio::posix::stream_descriptor event_;
  std::function<void()> callback_;
  uint64_t notifications_ = 0;
};

}  // namespace infuse::daemon
