#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <functional>

namespace infuse::daemon {

/// Lets a thread wake an `io_context` without allocating (an eventfd).
class Doorbell {
 public:
  /// `answer` is called on the thread of `io` some time after each `ring`; several may be answered
  /// once.
  Doorbell(boost::asio::io_context& io, std::function<void()> answer);

  /// From any thread.
  void ring();

  /// Answers no more.
  void close();

 private:
  void listen();

  boost::asio::posix::stream_descriptor event_;
  std::function<void()> answer_;
  uint64_t rings_ = 0;
};

}  // namespace infuse::daemon
