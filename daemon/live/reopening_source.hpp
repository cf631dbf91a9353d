#pragma once

#include <spdlog/spdlog.h>

#include <functional>
#include <optional>
#include <string>

#include "daemon/health/source_state.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// A source that is opened again whenever it is gone, ever less often. Of the io thread.
template <class Source>
class ReopeningSource {
 public:
  static constexpr Duration kMinRetryDelay{100'000'000};
  static constexpr Duration kMaxRetryDelay{2'000'000'000};

  /// `name` is for the log.
  ReopeningSource(std::string name, std::function<Result<Source>()> open)
      : name_(std::move(name)), open_(std::move(open)) {
    state_.open = false;
    state_.set_problem("not opened yet");
  }

  /// Null while it is gone.
  Source* get() { return source_ ? &*source_ : nullptr; }

  /// Opens it if it is gone and the pause is over. True where it has just been opened.
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

  /// It may be there again: the pause is over.
  void retry_now() { next_attempt_ = Stamp::earliest(); }

  /// It is gone.
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
