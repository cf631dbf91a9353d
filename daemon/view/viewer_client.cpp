#include "daemon/view/viewer_client.hpp"

#include <boost/asio/buffer.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

namespace infuse::daemon {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;

constexpr size_t kMaxViewerBytes = size_t{16} << 20;  // queued, but for a single message
constexpr size_t kMaxViewerTexts = 64;                // of these wait; more: it is closed
constexpr size_t kMaxViewerRequest = size_t{64} << 10;
constexpr size_t kMaxSubscriptions = 1024;
constexpr Duration kTimeStep{5'000'000};
constexpr std::chrono::seconds kViewerHandshake{10}, kViewerIdle{30};

}  // namespace

ViewerClient::ViewerClient(ViewStream&& stream, ViewerChannels& channels, std::string session,
                           std::function<void(const std::shared_ptr<ViewerClient>&)> on_end)
    : socket_(std::move(stream)),
      channels_(channels),
      session_(std::move(session)),
      on_end_(std::move(on_end)) {
  beast::get_lowest_layer(socket_).expires_never();
  socket_.set_option(websocket::stream_base::timeout{kViewerHandshake, kViewerIdle, true});
  socket_.read_message_max(kMaxViewerRequest);
  socket_.auto_fragment(false);
}

void ViewerClient::accept(Request request, std::string_view subprotocol) {
  request_ = std::move(request);
  socket_.set_option(websocket::stream_base::decorator(
      [protocol = std::string(subprotocol)](websocket::response_type& response) {
        response.set(http::field::sec_websocket_protocol, protocol);
      }));
  socket_.async_accept(request_, [self = shared_from_this()](beast::error_code error) {
    if (error) return self->end();
    self->open_ = true;
    self->send_text(server_info_text(self->session_, self->channels_.is_replay()));
    self->send_text(advertise_text(self->channels_.topics()));
    self->read();
  });
}

void ViewerClient::read() {
  socket_.async_read(buffer_, [self = shared_from_this()](beast::error_code error, size_t) {
    if (error) return self->end();
    if (self->socket_.got_text()) {
      self->handle(beast::buffers_to_string(self->buffer_.data()));
    } else {
      self->send_text(status_text(2, "this server accepts subscriptions only"));
    }
    self->buffer_.consume(self->buffer_.size());
    if (!self->ended_) self->read();
  });
}

void ViewerClient::handle(const std::string& text) {
  const ViewerRequest request = parse_viewer_request(text);
  if (!request.refused.empty()) return send_text(status_text(2, request.refused));
  for (const auto& subscription : request.subscribe) subscribe(subscription);
  for (const uint32_t id : request.unsubscribe) {
    const auto found = subscriptions_.find(id);
    if (found == subscriptions_.end()) continue;
    channels_.unsubscribe(found->second);
    subscriptions_.erase(found);
  }
}

void ViewerClient::subscribe(const ViewerRequest::Subscription& subscription) {
  const auto& [id, channel] = subscription;
  if (channel >= channels_.topics().size()) {
    return send_text(status_text(1, "there is no channel " + std::to_string(channel)));
  }
  if (subscriptions_.size() >= kMaxSubscriptions || !subscriptions_.emplace(id, channel).second) {
    return send_text(status_text(1, "subscription " + std::to_string(id) + " is not taken"));
  }
  channels_.subscribe(channel);
  if (const auto latched = channels_.latched(channel)) send_to(id, *latched);
}

void ViewerClient::send(const ViewerChannels::Message& message, uint64_t dropped) {
  if (!open_ || ended_) return;
  lost_ += dropped;
  for (const auto& [id, channel] : subscriptions_) {
    if (channel == message->channel) send_to(id, *message);
  }
}

void ViewerClient::send_to(uint32_t subscription, const ViewerMessage& message) {
  if (channels_.is_replay() && message.log_time >= time_ + kTimeStep) {
    time_ = message.log_time;
    enqueue({time_data(time_)});
  }
  if (!queue_.empty() && queued_bytes_ + message.payload.size() > kMaxViewerBytes) {
    ++lost_;
    return;
  }
  enqueue({message_data(subscription, message.log_time, message.payload)});
}

// A client that asks for notes and does not read them is not worth its memory.
void ViewerClient::send_text(std::string text) {
  size_t texts = 0;
  for (const Queued& queued : queue_) texts += queued.binary ? 0 : 1;
  if (texts >= kMaxViewerTexts) return close();
  enqueue({std::move(text), false});
}

void ViewerClient::enqueue(Queued queued) {
  if (ended_) return;
  queued_bytes_ += queued.data.size();
  queue_.push_back(std::move(queued));
  write();
}

void ViewerClient::write() {
  if (writing_ || ended_ || queue_.empty()) return;
  writing_ = true;
  socket_.binary(queue_.front().binary);
  socket_.async_write(
      boost::asio::buffer(queue_.front().data),
      [self = shared_from_this()](beast::error_code error, size_t) {
        self->writing_ = false;
        if (error) return self->end();
        self->queued_bytes_ -= self->queue_.front().data.size();
        self->queue_.pop_front();
        if (self->lost_ > 0 && self->queued_bytes_ < kMaxViewerBytes / 2) {
          self->enqueue({status_text(1, std::to_string(std::exchange(self->lost_, 0)) +
                                            " messages were dropped: the viewer does not keep up"),
                         false});
        }
        self->write();
      });
}

void ViewerClient::close() {
  beast::error_code ignored;
  beast::get_lowest_layer(socket_).socket().shutdown(boost::asio::socket_base::shutdown_both,
                                                     ignored);
}

void ViewerClient::end() {
  if (std::exchange(ended_, true)) return;
  for (const auto& [id, channel] : subscriptions_) channels_.unsubscribe(channel);
  subscriptions_.clear();
  on_end_(shared_from_this());
}

}  // namespace infuse::daemon
