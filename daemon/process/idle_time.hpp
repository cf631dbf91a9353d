#pragma once

#include <pthread.h>
#include <sched.h>

#include <mutex>
#include <optional>

namespace infuse::daemon {

/// Gives a thread only the processor time that nobody else wants (SCHED_IDLE), until it is to end:
/// then its usual share, so that a caller that joins it need not wait for all other processes.
/// Without privileges that needs RLIMIT_NICE of 20, as the unit has it (sched(7)).
class IdleTime {
 public:
  /// The calling thread is idle from now on, until the end of the scope.
  class Scope {
   public:
    explicit Scope(IdleTime& time) : time_(time) {
      const std::lock_guard lock(time_.mutex_);
      time_.thread_ = ::pthread_self();
      if (!time_.over_) time_.set(SCHED_IDLE);
    }
    ~Scope() {
      const std::lock_guard lock(time_.mutex_);
      time_.set(SCHED_OTHER);
      time_.thread_.reset();
    }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    IdleTime& time_;
  };

  /// The thread has its share again, for good; from any thread.
  void end() {
    const std::lock_guard lock(mutex_);
    over_ = true;
    if (thread_) set(SCHED_OTHER);
  }

 private:
  void set(int policy) const {
    const sched_param none{};
    ::pthread_setschedparam(*thread_, policy, &none);
  }

  std::mutex mutex_;
  std::optional<pthread_t> thread_;
  bool over_ = false;
};

}  // namespace infuse::daemon
