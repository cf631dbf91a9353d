#include "daemon/server/session.hpp"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/write.hpp>

#include "daemon/protocol/messages.hpp"

namespace infuse::daemon {
namespace {

namespace asio = boost::asio;
using ErrorCode = boost::system::error_code;

}  // namespace

template <class Reply>
void Session::reply(const Reply& reply) {
  queue(std::make_shared<const std::string>(message(reply) + '\n'));
}

Session::Session(Socket socket, const ServerOptions& options, const LastValues& last_values,
                 const Control& control, const ClientUser& user,
                 std::shared_ptr<TokenBucket> requests)
    : socket_(std::move(socket)),
      options_(options),
      last_values_(last_values),
      control_(control),
      user_(user),
      requests_(std::move(requests)),
      last_activity_(Clock::now()) {}

void Session::start(Line greeting) {
  queue(std::move(greeting));
  read();
}

// One read at a time, and none while the queue is full: requests of a client that does not read its
// answers stay in the kernel.
void Session::read() {
  if (reading_ || finishing_ || closed() || output_.size() >= options_.queue_reports) return;
  reading_ = true;
  const auto space = asio::buffer(input_.data() + input_size_, input_.size() - input_size_);
  socket_.async_read_some(space, [self = shared_from_this()](ErrorCode error, size_t bytes) {
    self->reading_ = false;
    if (error || self->closed()) return self->close();
    self->process_input(bytes);
  });
}

void Session::process_input(size_t bytes) {
  last_activity_ = Clock::now();
  input_size_ += bytes;
  size_t begin = 0;
  while (!finishing_) {
    const auto* end = std::find(input_.data() + begin, input_.data() + input_size_, '\n');
    if (end == input_.data() + input_size_) break;
    const std::string_view line(input_.data() + begin,
                                static_cast<size_t>(end - input_.data()) - begin);
    begin += line.size() + 1;
    answer(line);
  }
  std::copy(input_.data() + begin, input_.data() + input_size_, input_.data());
  input_size_ -= begin;
  if (input_size_ == input_.size()) {
    refuse("the request is longer than " + std::to_string(kMaxRequestBytes) + " bytes", "");
  }
  read();
}

void Session::answer(std::string_view line) {
  if (!requests_->take(Clock::now()))
    return refuse("too many requests", "watch instead of polling");
  const Result<Request> request = parse_request(line);
  if (!request) {
    const Error& error = request.error();
    return reply(ErrorReply{error.where, error.what, error.hint});
  }
  if (request->is_control()) return answer_control(*request);
  if (request->op == Request::Op::kPoll) return answer_poll();
  if (request->op == Request::Op::kDevices) {
    for (const LastValues::Entry& entry : last_values_.entries()) {
      if (entry.report_class == ReportClass::kDevices) return queue(entry.line);
    }
    return reply(ErrorReply{"devices", "no device is known yet", "retry later"});
  }
  watched_ = request->classes;
  reply(AckReply{"watch", ""});
}

void Session::answer_poll() {
  for (const LastValues::Entry& entry : last_values_.entries()) queue(entry.line);
  reply(AckReply{"poll", ""});
}

void Session::answer_control(const Request& request) {
  const char* op = name_of(request.op);
  if (!user_.is_owner) {
    return reply(ErrorReply{op, "permission denied",
                            "run as the daemon's user or as root, on its Unix socket"});
  }
  const Result<std::string> done = control_(request);
  if (done) return reply(AckReply{op, *done});
  const Error& error = done.error();
  const std::string where = error.where.empty() ? "" : error.where + ": ";
  reply(ErrorReply{op, where + error.what, error.hint});
}

void Session::refuse(std::string what, std::string hint) {
  reply(ErrorReply{"", std::move(what), std::move(hint)});
  finish();
}

// A client that has lost reports receives none until half of its queue is free: few long gaps
// instead of many short ones.
void Session::report(ReportClass report_class, Stamp stamp, const Line& line) {
  if (!watched_.has(report_class) || finishing_ || closed()) return;
  const size_t limit = lost_ == 0 ? options_.queue_reports : options_.queue_reports / 2;
  if (output_.size() >= limit) {
    ++lost_;
    return;
  }
  if (lost_ > 0) {
    reply(LostReport{stamp, lost_});
    lost_ = 0;
  }
  queue(line);
}

void Session::queue(Line line) {
  if (closed()) return;
  output_.push_back(std::move(line));
  if (in_flight_.empty()) write();
}

void Session::write() {
  constexpr size_t kMaxLinesPerWrite = 32;
  const size_t lines = std::min(output_.size(), kMaxLinesPerWrite);
  std::vector<asio::const_buffer> buffers;
  buffers.reserve(lines);
  for (size_t i = 0; i < lines; ++i) {
    in_flight_.push_back(std::move(output_.front()));
    output_.pop_front();
    buffers.push_back(asio::buffer(*in_flight_.back()));
  }
  asio::async_write(socket_, buffers, [self = shared_from_this()](ErrorCode error, size_t) {
    self->in_flight_.clear();
    if (error || self->closed()) return self->close();
    self->last_activity_ = Clock::now();
    if (!self->output_.empty()) {
      self->write();
    } else if (self->finishing_) {
      return self->close();
    }
    self->read();
  });
}

void Session::finish() {
  finishing_ = true;
  if (in_flight_.empty()) close();
}

void Session::close() {
  ErrorCode ignored;
  socket_.shutdown(Socket::shutdown_both, ignored);
  socket_.close(ignored);
}

}  // namespace infuse::daemon
