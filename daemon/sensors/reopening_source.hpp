#pragma once

#include <spdlog/spdlog.h>

#include <functional>
#include <optional>
#include <string>

#include "daemon/health/source_state.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// A source that is reopened whenever it is lost, with increasing delays. Used by the io thread
/// only.
template <class Source>
class ReopeningSource {
 public:
  static constexpr Duration kMinRetryDelay{100'000'000};
  static constexpr Duration kMaxRetryDelay{2'000'000'000};

  /// `name` identifies the source in the log.
  ReopeningSource(std::string name, std::function<Result<Source>()> open)
      : name_(std::move(name)), open_(std::move(open)) {
    state_.open = false;
    state_.set_problem("not opened yet");
  }

  /// Returns the source, or null while it is closed.
  Source* get() { return source_ ? &*source_ : nullptr; }

  /// Opens the source if it is closed and the delay is over. Returns true if it has just been
  /// opened.
  bool reopen_if_due(Stamp now) {
    if (source_ || now < next_attempt_) return false;
    auto opened = open_();
    if (!opened) {
      if (retry_delay_ == Duration::zero()) spdlog::warn("{}: {}", name_, opened.error().message());
      mark_closed(opened.error());
      retry_delay_ = retry_delay_ == Duration::zero() ? kMinRetryDelay
                                                      : std::min(2 * retry_delay_, kMaxRetryDelay);
      next_attempt_ = now + retry_delay_;
      return false;
    }
    source_.emplace(*std::move(opened));
    spdlog::info("{}: opened", name_);
    state_.open = true;
    state_.problem.fill('\0');
    ++state_.open_count;
    retry_delay_ = Duration::zero();
    return true;
  }

  /// Ends the delay: the source may be available again.
  void retry_now() { next_attempt_ = Stamp::earliest(); }

  /// Closes the source after an error.
  void close(const Error& error, Stamp now) {
    spdlog::warn("{}: {}", name_, error.message());
    source_.reset();
    mark_closed(error);
    retry_delay_ = kMinRetryDelay;
    next_attempt_ = now + retry_delay_;
  }

  SourceState& state() { return state_; }

 private:
  void mark_closed(const Error& error) {
    state_.open = false;
    state_.set_problem(error.message());
  }

  std::string name_;
  std::function<Result<Source>()> open_;
  std::optional<Source> source_;
  SourceState state_;
  Duration retry_delay_{0};
  Stamp next_attempt_ = Stamp::earliest();
};

}  // namespace infuse::daemon
