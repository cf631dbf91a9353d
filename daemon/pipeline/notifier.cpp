#include "daemon/pipeline/notifier.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <boost/asio/buffer.hpp>

namespace infuse::daemon {

Notifier::Notifier(boost::asio::io_context& io, std::function<void()> callback)
    : event_(io, ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)), callback_(std::move(callback)) {
  listen();
}

void Notifier::notify() {
  const uint64_t one = 1;
  // Fails only after 2^64 notifications without a call.
  [[maybe_unused]] const auto written = ::write(event_.native_handle(), &one, sizeof(one));
}

void Notifier::close() {
  boost::system::error_code ignored;
  event_.close(ignored);
}

void Notifier::listen() {
  event_.async_read_some(boost::asio::buffer(&notifications_, sizeof(notifications_)),
                         [this](boost::system::error_code error, size_t) {
                           if (error) return;
                           callback_();
                           if (event_.is_open()) listen();
                         });
}

}  // namespace infuse::daemon
