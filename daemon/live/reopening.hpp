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
class Reopening {
 public:
  static constexpr Duration kFirstPause{100'000'000};
  static constexpr Duration kLongestPause{2'000'000'000};

  /// `name` is for the log.
  Reopening(std::string name, std::function<Result<Source>()> open)
      : name_(std::move(name)), open_(std::move(open)) {
    state_.open = false;
    state_.set_problem("not opened yet");
  }

  /// Null while it is gone.
  Source* get() { return source_ ? &*source_ : nullptr; }

  /// Opens it if it is gone and the pause is over. True where it has just been opened.
  bool look_after(Stamp now) {
    if (source_ || now < next_) return false;
    auto opened = open_();
    if (!opened) {
      if (pause_ == Duration::zero()) spdlog::warn("{}: {}", name_, opened.error().message());
      note(opened.error());
      pause_ = pause_ == Duration::zero() ? kFirstPause : std::min(2 * pause_, kLongestPause);
      next_ = now + pause_;
      return false;
    }
    source_.emplace(*std::move(opened));
    spdlog::info("{}: opened", name_);
    state_.open = true;
    state_.problem.fill('\0');
    ++state_.opened;
    pause_ = Duration::zero();
    return true;
  }

  /// It may be there again: the pause is over.
  void hurry() { next_ = Stamp::earliest(); }

  /// It is gone.
  void lose(const Error& error, Stamp now) {
    spdlog::warn("{}: {}", name_, error.message());
    source_.reset();
    note(error);
    pause_ = kFirstPause;
    next_ = now + pause_;
  }

  SourceState& state() { return state_; }

 private:
  void note(const Error& error) {
    state_.open = false;
    state_.set_problem(error.message());
  }

  std::string name_;
  std::function<Result<Source>()> open_;
  std::optional<Source> source_;
  SourceState state_;
  Duration pause_{0};
  Stamp next_ = Stamp::earliest();
};

}  // namespace infuse::daemon
