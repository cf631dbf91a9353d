#include "daemon/pipeline/doorbell.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <boost/asio/buffer.hpp>

namespace infuse::daemon {

Doorbell::Doorbell(boost::asio::io_context& io, std::function<void()> answer)
    : event_(io, ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)), answer_(std::move(answer)) {
  listen();
}

void Doorbell::ring() {
  const uint64_t one = 1;
  // It fails only when it has been rung 2^64 times and not been answered.
  [[maybe_unused]] const auto written = ::write(event_.native_handle(), &one, sizeof(one));
}

void Doorbell::close() {
  boost::system::error_code ignored;
  event_.close(ignored);
}

void Doorbell::listen() {
  event_.async_read_some(boost::asio::buffer(&rings_, sizeof(rings_)),
                         [this](boost::system::error_code error, size_t) {
                           if (error) return;
                           answer_();
                           if (event_.is_open()) listen();
                         });
}

}  // namespace infuse::daemon
