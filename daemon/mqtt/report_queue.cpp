#include "daemon/mqtt/report_queue.hpp"

#include <algorithm>
#include <system_error>
#include <tuple>

namespace infuse::daemon {
namespace {

/// A name for the damaged file that no other has.
std::string name_aside(const std::filesystem::path& path) {
  constexpr int kMaxKept = 1000;
  std::string name = path.string() + ".damaged";
  std::error_code failed;
  for (int i = 1; i < kMaxKept && std::filesystem::exists(name, failed); ++i) {
    name = path.string() + ".damaged." + std::to_string(i);
  }
  return name;
}

/// Sets the file of a database aside, with what belongs to it. Returns its new name.
std::string set_aside(const std::filesystem::path& path) {
  const std::string aside = name_aside(path);
  std::error_code failed;
  for (const char* suffix : {"", "-wal", "-shm"}) {
    const std::filesystem::path file = path.string() + suffix;
    if (std::filesystem::exists(file, failed)) {
      std::filesystem::rename(file, aside + suffix, failed);
    }
  }
  return aside;
}

}  // namespace

ReportQueue::ReportQueue(std::filesystem::path path, uint64_t max_bytes)
    : path_(std::move(path)), max_bytes_(max_bytes) {
  if (!path_.empty()) open_file();
}

// A damaged file is kept for who wants to know, and a new one is begun.
bool ReportQueue::open_file() {
  auto file = ReportFile::open(path_);
  if (!file && file.error().damaged) {
    damage_ = file.error().what + "; kept as " + set_aside(path_);
    file = ReportFile::open(path_);
    if (!file && file.error().damaged) damage_.clear();  // it cannot be renamed
  }
  if (!file) {
    disk_problem_ = file.error().what;
    return false;
  }
  if (const auto moved = move_to_file(*file); !moved) {
    disk_problem_ = moved.error().message();
    return false;
  }
  disk_problem_.clear();
  std::tie(messages_, bytes_) = file->totals();
  last_id_ = file->last_id();
  file_ = *std::move(file);
  make_room(0);
  return true;
}

bool ReportQueue::try_file() { return !path_.empty() && !file_ && open_file(); }

void ReportQueue::leave_file(const Error& why) {
  disk_problem_ = why.message();
  file_.reset();
  messages_ = bytes_ = 0;
}

Result<void> ReportQueue::move_to_file(ReportFile& file) {
  auto moved = file.change_at_once([&]() -> Result<void> {
    for (const int64_t id : published_) {
      if (auto removed = file.remove(id); !removed) return tl::unexpected(removed.error());
    }
    for (const std::string& topic : newer_topics_) {
      if (auto stopped = file.stop_retaining(topic); !stopped) return stopped;
    }
    for (const auto& [id, report] : memory_) {
      if (auto added = file.add(report); !added) return tl::unexpected(added.error());
    }
    return {};
  });
  if (!moved) return moved;
  published_.clear();
  newer_topics_.clear();
  memory_.clear();
  by_importance_.clear();
  return {};
}

Result<void> ReportQueue::add(const QueuedReport& report) {
  if (report.bytes() > max_bytes_) {
    ++dropped_;
    return fail("a report of " + std::to_string(report.bytes()) + " bytes exceeds queue_mb");
  }
  make_room(report.bytes());
  if (file_) {
    if (const auto added = file_->add(report); !added) {
      leave_file(added.error());
      make_room(report.bytes());
    } else {
      last_id_ = *added;
    }
  }
  if (!file_) {
    const int64_t id = ++last_id_;
    by_importance_.insert({report.importance, id});
    memory_.emplace(id, report).first->second.id = id;
    if (report.retain) newer_topics_.insert(report.topic);
  }
  ++messages_;
  bytes_ += report.bytes();
  return {};
}

/// Drops messages until `bytes` more fit.
void ReportQueue::make_room(uint64_t bytes) {
  while (bytes_ + bytes > max_bytes_ && drop_lowest_importance()) {
  }
}

bool ReportQueue::drop_lowest_importance() {
  if (messages_ == 0) return false;
  if (!file_) {
    remove_from_memory(by_importance_.begin()->second);
    ++dropped_;
    return true;
  }
  const auto least = file_->lowest_importance();
  const uint64_t before = messages_;
  if (!least) leave_file(least.error());
  if (!least || !*least) return false;
  remove(**least);
  if (!file_ || messages_ == before) return false;
  ++dropped_;
  return true;
}

std::optional<QueuedReport> ReportQueue::next_after(int64_t id) {
  if (file_) {
    auto next = file_->next_after(id);
    if (next) return *std::move(next);
    leave_file(next.error());
  }
  const auto next = memory_.upper_bound(id);
  if (next == memory_.end()) return std::nullopt;
  return next->second;
}

void ReportQueue::remove(int64_t id) {
  if (!file_) {
    if (memory_.contains(id)) return remove_from_memory(id);
    if (!path_.empty()) published_.push_back(id);
    return;
  }
  const auto removed = file_->remove(id);
  if (!removed) {
    leave_file(removed.error());
    published_.push_back(id);
  } else if (*removed > 0) {
    --messages_;
    bytes_ -= std::min(bytes_, *removed);
  }
}

void ReportQueue::remove_from_memory(int64_t id) {
  const auto found = memory_.find(id);
  by_importance_.erase({found->second.importance, id});
  --messages_;
  bytes_ -= found->second.bytes();
  memory_.erase(found);
}

}  // namespace infuse::daemon
