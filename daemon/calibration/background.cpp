#include "daemon/calibration/background.hpp"

#include <pthread.h>
#include <sched.h>

#include <utility>

namespace infuse::daemon {

Background::Background(bool waits) : waits_(waits), thread_([this] { run(); }) {}

Background::~Background() { shut_down(); }

void Background::run() {
  pthread_setname_np(pthread_self(), "background");
  if (!waits_) {  // who waits for it must not wait for others
    const sched_param none{};
    pthread_setschedparam(pthread_self(), SCHED_IDLE, &none);
  }
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return shut_ || work_ != nullptr; });
    if (shut_) return;
    const Work work = std::exchange(work_, nullptr);
    const std::stop_token stop = stop_.get_token();
    lock.unlock();
    work(stop);
    lock.lock();
    done_ = true;
    changed_.notify_all();
  }
}

void Background::start(Stamp now, Duration budget, Work work) {
  visible_ = now + budget;
  {
    const std::lock_guard lock(mutex_);
    if (shut_) return;
    work_ = std::move(work);
    stop_ = {};
    done_ = false;
  }
  changed_.notify_all();
}

bool Background::busy() const {
  const std::lock_guard lock(mutex_);
  return visible_.has_value() || !done_;
}

bool Background::take(Stamp now) {
  if (!visible_ || now < *visible_) return false;
  std::unique_lock lock(mutex_);
  if (waits_) changed_.wait(lock, [this] { return done_ || shut_; });
  if (!done_ || shut_) return false;
  visible_.reset();
  return true;
}

void Background::cancel() {
  visible_.reset();
  std::unique_lock lock(mutex_);
  stop_.request_stop();
  if (waits_) changed_.wait(lock, [this] { return done_ || shut_; });
}

void Background::shut_down() {
  {
    const std::lock_guard lock(mutex_);
    shut_ = true;
    stop_.request_stop();
  }
  changed_.notify_all();
}

}  // namespace infuse::daemon
