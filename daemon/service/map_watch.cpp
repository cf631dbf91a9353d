#include "daemon/service/map_watch.hpp"

#include <pthread.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "daemon/process/crash_note.hpp"

namespace infuse::daemon {
namespace {

constexpr std::chrono::seconds kMinRetry{5}, kMaxRetry{300};

}  // namespace

MapWatch::MapWatch(std::string name, std::filesystem::path file, std::string digest,
                   Replace replace)
    : file_(std::move(file)),
      in_use_{std::move(name), std::move(digest), ""},
      replace_(std::move(replace)) {}

MapWatch::Mark MapWatch::mark() const {
  struct stat about {};
  if (::stat(file_.c_str(), &about) != 0) return {};
  constexpr int64_t kNanosecondsPerSecond = 1'000'000'000;
  return {about.st_dev, about.st_ino, about.st_size,
          about.st_ctim.tv_sec * kNanosecondsPerSecond + about.st_ctim.tv_nsec};
}

bool MapWatch::looks() const {
  return looking_.valid() &&
         looking_.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
}

void MapWatch::poll(Clock::time_point now) {
  if (looking_.valid()) {
    if (looks()) return;
    return settle(now);
  }
  const Mark before = std::exchange(seen_, mark());
  const bool changed = seen_ != looked_at_ && seen_ == before;
  if (!changed && now < due_) return;
  if (changed) pause_ = std::chrono::seconds(0);
  looked_at_ = seen_;
  due_ = Clock::time_point::max();
  looking_ =
      std::async(std::launch::async, [this, in_use = in_use_.digest]() -> Result<std::string> {
        ::pthread_setname_np(::pthread_self(), "maps");
        use_crash_stack();
        const IdleTime::Scope idle(idle_);
        try {
          return replace_(in_use, stop_.get_token());
        } catch (const std::exception& failed) {  // no memory, no thread
          return fail(std::string("cannot be put in use: ") + failed.what(), file_.string());
        }
      });
}

void MapWatch::settle(Clock::time_point now) {
  const auto found = looking_.get();
  if (!found) {
    if (in_use_.problem != found.error().message()) {
      spdlog::warn("the new {} is refused: {}; {} stays in use", in_use_.name,
                   found.error().message(), in_use_.digest);
    }
    in_use_.problem = found.error().message();
    pause_ = std::clamp(2 * pause_, kMinRetry, kMaxRetry);
    due_ = now + pause_;
    return;
  }
  in_use_.problem.clear();
  pause_ = std::chrono::seconds(0);
  due_ = Clock::time_point::max();
  const std::string before = std::exchange(in_use_.digest, *found);
  if (before != *found) spdlog::info("{} {} takes the place of {}", in_use_.name, *found, before);
}

}  // namespace infuse::daemon
