#include "daemon/calibration/background_worker.hpp"

#include <pthread.h>

#include <utility>

#include "daemon/process/crash_note.hpp"

namespace infuse::daemon {

BackgroundWorker::BackgroundWorker(bool blocking)
    : blocking_(blocking), thread_([this] { run(); }) {}

BackgroundWorker::~BackgroundWorker() { shut_down(); }

void BackgroundWorker::run() {
  pthread_setname_np(pthread_self(), "background");
  use_crash_stack();
  std::optional<IdleTime::Scope> idle;
  if (!blocking_) idle.emplace(idle_);  // a blocking caller must not wait for other processes
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return shut_down_ || work_ != nullptr; });
    if (shut_down_) return;
    const Work work = std::exchange(work_, nullptr);
    const std::stop_token stop = stop_.get_token();
    lock.unlock();
    work(stop);
    lock.lock();
    done_ = true;
    changed_.notify_all();
  }
}

void BackgroundWorker::start(Stamp now, Duration budget, Work work) {
  visible_at_ = now + budget;
  {
    const std::lock_guard lock(mutex_);
    if (shut_down_) return;
    work_ = std::move(work);
    stop_ = {};
    done_ = false;
  }
  changed_.notify_all();
}

bool BackgroundWorker::busy() const {
  const std::lock_guard lock(mutex_);
  return visible_at_.has_value() || !done_;
}

bool BackgroundWorker::consume_result(Stamp now) {
  if (!visible_at_ || now < *visible_at_) return false;
  std::unique_lock lock(mutex_);
  if (blocking_) changed_.wait(lock, [this] { return done_ || shut_down_; });
  if (!done_ || shut_down_) return false;
  visible_at_.reset();
  return true;
}

void BackgroundWorker::cancel() {
  visible_at_.reset();
  std::unique_lock lock(mutex_);
  stop_.request_stop();
  if (blocking_) changed_.wait(lock, [this] { return done_ || shut_down_; });
}

void BackgroundWorker::shut_down() {
  {
    const std::lock_guard lock(mutex_);
    shut_down_ = true;
    stop_.request_stop();
  }
  idle_.end();
  changed_.notify_all();
}

}  // namespace infuse::daemon
