#pragma once

#include <array>
#include <boost/asio/generic/stream_protocol.hpp>
#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "daemon/protocol/request.hpp"
#include "daemon/server/client_limits.hpp"
#include "daemon/server/last_values.hpp"
#include "daemon/server/server_options.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Session of one client: reads its requests, writes replies and reports. Lives as long as an
/// operation of its socket is pending. Single-threaded.
class Session : public std::enable_shared_from_this<Session> {
 public:
  using Socket = boost::asio::generic::stream_protocol::socket;
  using Clock = ServerClock;

  /// Handler of a control request; its error is sent to the client.
  using Control = std::function<Result<std::string>(const Request&)>;

  /// `last_values` and `control` outlive the session. `user`: the owner may send control requests.
  /// `requests`: limits the requests of all sessions of this user.
  Session(Socket socket, const ServerOptions& options, const LastValues& last_values,
          const Control& control, const ClientUser& user, std::shared_ptr<TokenBucket> requests);

  /// Sends the greeting and starts reading.
  void start(Line greeting);

  /// Queues the report if the client watches its class; counts it as lost if its queue is full.
  void report(ReportClass report_class, Stamp stamp, const Line& line);

  /// Closes the connection when its queue was sent.
  void finish();

  /// Closes the connection at once.
  void close();

  const ClientUser& user() const { return user_; }

  bool closed() const { return !socket_.is_open(); }

  /// Time of the last read from or write to the client.
  Clock::time_point last_activity() const { return last_activity_; }

 private:
  void read();
  void process_input(size_t bytes);
  void answer(std::string_view line);
  template <class Reply>
  void reply(const Reply& reply);
  void refuse(std::string what, std::string hint);
  void answer_poll();
  void answer_control(const Request& request);
  void queue(Line line);
  void write();

  Socket socket_;
  const ServerOptions options_;
  const LastValues& last_values_;
  const Control& control_;
  const ClientUser user_;
  const std::shared_ptr<TokenBucket> requests_;
  ReportClasses watched_;

  std::array<char, kMaxRequestBytes + 1> input_{};
  size_t input_size_ = 0;
  Clock::time_point last_activity_;

  std::deque<Line> output_;
  std::vector<Line> in_flight_;
  uint64_t lost_ = 0;
  bool reading_ = false;
  bool finishing_ = false;
};

}  // namespace infuse::daemon
