#include "daemon/view/view_client.hpp"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <utility>

namespace infuse::daemon {
namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;

constexpr size_t kMaxQueue = 256;     // number of messages
constexpr size_t kMaxCommand = 1024;  // bytes
constexpr std::chrono::seconds kHandshake{10}, kIdle{30};

}  // namespace

ViewClient::ViewClient(ViewStream&& stream, Handlers handlers)
    : socket_(std::move(stream)), handlers_(std::move(handlers)) {
  beast::get_lowest_layer(socket_).expires_never();
  socket_.set_option(websocket::stream_base::timeout{kHandshake, kIdle, true});
  socket_.read_message_max(kMaxCommand);
  socket_.auto_fragment(false);
}

void ViewClient::accept(Request request) {
  request_ = std::move(request);
  socket_.async_accept(request_, [self = shared_from_this()](beast::error_code error) {
    if (error) return self->end();
    self->open_ = true;
    self->handlers_.on_open(self);
    self->read();
  });
}

void ViewClient::send(const Message& message) {
  if (!open_ || ended_) return;
  const auto waiting = std::find_if(
      queue_.begin() + (writing_ ? 1 : 0), queue_.end(),
      [&](const Message& one) { return message->binary() && one->key == message->key; });
  if (waiting != queue_.end()) *waiting = message;
  if (waiting != queue_.end() || queue_.size() >= kMaxQueue) {
    ++lost_;
    return;
  }
  queue_.push_back(message);
  write();
}

void ViewClient::write() {
  if (writing_ || ended_ || queue_.empty()) return;
  writing_ = true;
  socket_.binary(queue_.front()->binary());
  socket_.async_write(boost::asio::buffer(queue_.front()->data),
                      [self = shared_from_this()](beast::error_code error, size_t) {
                        self->writing_ = false;
                        if (error) return self->end();
                        self->queue_.pop_front();
                        if (self->lost_ > 0 && self->queue_.size() < kMaxQueue / 2) {
                          const uint64_t lost = std::exchange(self->lost_, 0);
                          self->queue_.push_back(std::make_shared<const ViewMessage>(ViewMessage{
                              R"({"class":"LOST","count":)" + std::to_string(lost) + "}"}));
                        }
                        self->write();
                      });
}

void ViewClient::read() {
  socket_.async_read(buffer_, [self = shared_from_this()](beast::error_code error, size_t) {
    if (error) return self->end();
    if (self->socket_.got_text()) {
      self->handlers_.on_command(self, beast::buffers_to_string(self->buffer_.data()));
    }
    self->buffer_.consume(self->buffer_.size());
    self->read();
  });
}

void ViewClient::close() {
  beast::error_code ignored;
  beast::get_lowest_layer(socket_).socket().shutdown(boost::asio::socket_base::shutdown_both,
                                                     ignored);
}

void ViewClient::end() {
  if (!std::exchange(ended_, true)) handlers_.on_end(shared_from_this());
}

}  // namespace infuse::daemon
