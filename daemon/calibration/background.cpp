#include "daemon/calibration/background.hpp"

#include <pthread.h>
#include <sched.h>

namespace infuse::daemon {

Background::Background(bool waits)
    : waits_(waits), thread_([this](std::stop_token stop) { run(stop); }) {}

Background::~Background() {
  thread_.request_stop();
  changed_.notify_all();
}

void Background::run(std::stop_token stop) {
  pthread_setname_np(pthread_self(), "background");
  if (!waits_) {  // who waits for it must not wait for others
    const sched_param none{};
    pthread_setschedparam(pthread_self(), SCHED_IDLE, &none);
  }
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return work_ != nullptr; })) {
    const std::function<void()> work = std::move(work_);
    work_ = nullptr;
    lock.unlock();
    work();
    lock.lock();
    done_ = true;
    changed_.notify_all();
  }
}

void Background::start(Stamp now, Duration budget, std::function<void()> work) {
  visible_ = now + budget;
  {
    const std::lock_guard lock(mutex_);
    work_ = std::move(work);
    done_ = false;
  }
  changed_.notify_all();
}

bool Background::take(Stamp now) {
  if (!visible_ || now < *visible_) return false;
  std::unique_lock lock(mutex_);
  if (waits_) changed_.wait(lock, [this] { return done_; });
  if (!done_) return false;
  visible_.reset();
  return true;
}

}  // namespace infuse::daemon
