#include "daemon/record/recorder.hpp"

#include "daemon/pipeline/threads.hpp"

namespace infuse::daemon {
namespace {

constexpr int kCore = 0;  // the other core is reserved for the fusion thread
constexpr Duration kWritePeriod{100'000'000};
constexpr Duration kDrainTimeout{1'000'000'000};

RecordChunk new_chunk() {
  RecordChunk chunk;
  chunk.bytes.reserve(RecordChunk::kMaxBytes);
  return chunk;
}

}  // namespace

Recorder::Recorder(const RecordSettings& settings, std::filesystem::path directory,
                   std::function<Stamp()> now, RecorderThread thread)
    : settings_(settings),
      directory_(std::move(directory)),
      now_(std::move(now)),
      budget_(directory_, settings.budget),
      ring_(static_cast<size_t>(settings.memory / RecordChunk::kMaxBytes), new_chunk),
      reader_(ring_.make_reader()),
      tap_(ring_) {
  tap_.set_enabled(settings_.flight_recorder > Duration::zero());
  if (thread == RecorderThread::kNone) return;
  thread_ = std::jthread([this](std::stop_token stop) { run(std::move(stop)); });
}

void Recorder::begin(Recording recording) {
  {
    const std::lock_guard lock(mutex_);
    report_ = recording.report();
    next_ = std::move(recording);
    until_.reset();
    tap_.set_enabled(true);
  }
  requested_.notify_one();
}

void Recorder::end_at(Stamp until) {
  const std::lock_guard lock(mutex_);
  until_ = until;
}

std::optional<RecordReport> Recorder::report() const {
  const std::lock_guard lock(mutex_);
  return report_;
}

bool Recorder::is_recording() const {
  const std::lock_guard lock(mutex_);
  return report_ && !report_->ended;
}

void Recorder::finish() {
  tap_.finish();
  if (thread_.joinable()) {
    thread_.request_stop();
    thread_.join();
  } else {
    std::unique_lock lock(mutex_);
    apply_requests(lock);
    lock.unlock();
    write_rest();
  }
}

void Recorder::work() {
  std::unique_lock lock(mutex_);
  apply_requests(lock);
  lock.unlock();
  if (!recording_) return;
  write_chunks(kWritePeriod);
  update_report();
}

void Recorder::run(std::stop_token stop) {
  name_and_pin("record", kCore);
  while (process_requests(stop)) {
    reader_.wait(kWritePeriod);
    write_chunks(kWritePeriod);
    update_report();
  }
  write_rest();
}

void Recorder::write_rest() {
  if (!recording_) return;
  write_chunks(kDrainTimeout);
  recording_->end("the daemon ended");
  update_report();
}

// Sleeps while there is nothing to record. Returns false when the thread is to end.
bool Recorder::process_requests(std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  if (!recording_) requested_.wait(lock, stop, [this] { return next_.has_value(); });
  apply_requests(lock);
  return !stop.stop_requested();
}

void Recorder::apply_requests(std::unique_lock<std::mutex>& lock) {
  if (next_) {
    if (recording_) recording_->end("another recording was started");
    recording_ = std::exchange(next_, std::nullopt);
    parser_ = {};
    lock.unlock();
    budget_.measure(recording_->report().name);
    lock.lock();
  }
  if (recording_ && until_) recording_->end_at(*until_);
}

void Recorder::write_chunks(Duration timeout) {
  const Stamp begin = now_();
  bool caught_up = false;
  while (!caught_up && now_() - begin < timeout) {
    const Pin<RecordChunk> chunk = reader_.next();
    caught_up = !chunk;
    if (chunk) parser_.parse(*chunk, [this](const Record& record) { recording_->add(record); });
  }
  recording_->flush_and_check(now_(), parser_.lost(), caught_up);
  if (recording_->report().ended || budget_.make_room(recording_->report().bytes)) return;
  recording_->end("budget_mb is used up by recordings on request; remove some", true);
}

void Recorder::update_report() {
  const bool ended = recording_->report().ended;
  {
    const std::lock_guard lock(mutex_);
    if (!next_) report_ = recording_->report();
    if (ended && !next_) tap_.set_enabled(settings_.flight_recorder > Duration::zero());
  }
  if (!ended) return;
  const std::string name = recording_->report().name;
  recording_.reset();
  remove_old_alerts(directory_, settings_.keep_alerts, name);
}

}  // namespace infuse::daemon
