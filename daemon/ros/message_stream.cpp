#include "daemon/ros/message_stream.hpp"

#include <algorithm>

#include "daemon/pipeline/datagram_batch.hpp"
#include "daemon/pipeline/threads.hpp"
#include "daemon/record/image_file.hpp"
#include "daemon/ros/report_messages.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kMaxSweepCopies = 8;      // live, waiting
constexpr size_t kMaxReportLines = 4096;   // live, waiting
constexpr int kMaxItemsInTurn = 64;        // then sweeps and reports
constexpr Duration kItemWait{20'000'000};  // sweeps and reports come with items
constexpr int kStreamCore = 0;             // the other one is the fusion thread's

bool is_png(std::span<const uint8_t> bytes) { return bytes.size() > 1 && bytes[1] == 'P'; }

Stamp end_of(const Sweep& sweep) { return sweep.stamp + sweep.span; }

}  // namespace

bool MessageStream::Tee::wants(const std::string& topic) const {
  return std::ranges::any_of(sinks_, [&](const auto* sink) { return sink->wants(topic); });
}

void MessageStream::Tee::add(const std::string& topic, const char* type, Stamp log_time,
                             bool latched, std::span<const uint8_t> bytes) {
  for (MessageSink* sink : sinks_) {
    if (sink->wants(topic)) sink->add(topic, type, log_time, latched, bytes);
  }
}

void MessageStream::Tee::begin_lane(Lane lane) {
  for (MessageSink* sink : sinks_) sink->begin_lane(lane);
}

void MessageStream::Tee::end_second() {
  for (MessageSink* sink : sinks_) sink->end_second();
}

MessageStream::MessageStream(const MessageSetup& setup, std::vector<MessageSink*> sinks,
                             std::function<bool()> wanted)
    : setup_(setup), sink_(std::move(sinks)), wanted_(std::move(wanted)), messages_(setup, sink_) {
  for (const LidarMount& lidar : setup.rig.lidars) lidar_topics_.emplace_back(lidar.name);
}

void MessageStream::start(SlotRing<StreamItem>& items) {
  items_.emplace(items.make_reader());
  thread_ = std::jthread([this](const std::stop_token& stop) {
    name_and_pin("messages", kStreamCore);
    run(stop);
  });
}

void MessageStream::finish() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  wake();
  thread_.join();
  items_.reset();
}

void MessageStream::wake() {
  const std::lock_guard lock(mutex_);
  wake_.notify_all();
}

uint64_t MessageStream::lost() const { return lost_items_ + lost_sweeps_ + lost_reports_; }

QueueStats MessageStream::stats() const {
  const std::lock_guard lock(mutex_);
  return {"messages", static_cast<uint32_t>(sweeps_.size()), static_cast<uint32_t>(kMaxSweepCopies),
          lost()};
}

void MessageStream::append_notes(std::vector<Error>& notes) const {
  messages_.append_notes(notes);
  if (unreadable_images_ > 0) {
    notes.push_back(
        {std::to_string(unreadable_images_) + " images are not written: they cannot be read", "",
         ""});
  }
}

// --- on the threads of the pipeline ---

bool MessageStream::wants_datagrams(LidarIndex lidar) const {
  if (asleep_.load(std::memory_order_relaxed)) return false;
  const LidarTopics& topics = lidar_topics_[lidar];
  return sink_.wants(topics.packets) || sink_.wants(topics.position_packets);
}

std::unique_ptr<MessageStream::SweepCopy> MessageStream::unused_copy() {
  const std::lock_guard lock(mutex_);
  if (setup_.live && sweeps_.size() >= kMaxSweepCopies) return nullptr;
  if (unused_.empty()) return std::make_unique<SweepCopy>();
  auto copy = std::move(unused_.back());
  unused_.pop_back();
  return copy;
}

void MessageStream::push_copy(std::unique_ptr<SweepCopy> copy) {
  const std::lock_guard lock(mutex_);
  sweeps_.push_back(std::move(copy));
}

void MessageStream::add_sweep(const SweepSnapshot& snapshot) {
  if (!snapshot.deskewed.usable() || snapshot.sweep.deskewed) return;
  if (asleep_.load(std::memory_order_relaxed)) return;
  if (!sink_.wants(lidar_topics_[snapshot.lidar].points)) return;
  auto copy = unused_copy();
  if (!copy) {
    ++lost_sweeps_;
    return;
  }
  copy->lidar = snapshot.lidar;
  copy->reference = snapshot.deskewed.reference;
  copy->sweep = snapshot.sweep;
  copy->sweep.x = snapshot.deskewed.x;
  copy->sweep.y = snapshot.deskewed.y;
  copy->sweep.z = snapshot.deskewed.z;
  push_copy(std::move(copy));
}

void MessageStream::end_second() {
  if (setup_.live) return;
  auto mark = std::make_unique<SweepCopy>();
  push_copy(std::move(mark));
}

void MessageStream::add_report(ReportClass report_class, const std::string& line) {
  if (report_class != ReportClass::kPose && report_class != ReportClass::kAlert &&
      report_class != ReportClass::kHealth)
    return;
  if (asleep_.load(std::memory_order_relaxed)) return;
  const std::lock_guard lock(mutex_);
  if (setup_.live && reports_.size() >= kMaxReportLines) {
    ++lost_reports_;
    return;
  }
  reports_.emplace_back(report_class, line);
}

// --- on the stream's thread ---

void MessageStream::run(const std::stop_token& stop) {
  while (true) {
    if (setup_.live && !sleep_until_wanted(stop)) break;
    const bool ending = stop.stop_requested();
    bool any = read_items();
    any = read_sweeps() || any;
    any = read_reports() || any;
    if (any) continue;
    if (ending) break;
    static_cast<void>(items_->wait(kItemWait));
  }
  sink_.begin_lane(MessageSink::Lane::kSensors);
  messages_.finish();
  for (const auto lane :
       {MessageSink::Lane::kSensors, MessageSink::Lane::kSweeps, MessageSink::Lane::kReports}) {
    sink_.begin_lane(lane);
    sink_.end_second();
  }
}

// False if the stream ends.
bool MessageStream::sleep_until_wanted(const std::stop_token& stop) {
  if (wanted_()) return true;
  asleep_.store(true, std::memory_order_relaxed);
  std::unique_lock lock(mutex_);
  const bool wanted = wake_.wait(lock, stop, [this] { return wanted_(); });
  sweeps_.clear();
  reports_.clear();
  lock.unlock();
  asleep_.store(false, std::memory_order_relaxed);
  if (!wanted) return false;
  // What has passed meanwhile was not wanted.
  const uint64_t before = items_->lost();
  static_cast<void>(items_->next());
  lost_before_ += items_->lost() - before;
  return true;
}

bool MessageStream::read_items() {
  sink_.begin_lane(MessageSink::Lane::kSensors);
  bool any = false;
  for (int k = 0; k < kMaxItemsInTurn; ++k) {
    const Pin<StreamItem> item = items_->next();
    lost_items_ = items_->lost() - lost_before_;
    if (!item) return any;
    any = true;
    write_item(*item);
  }
  return any;
}

void MessageStream::write_item(const StreamItem& item) {
  if (!std::exchange(started_, true)) messages_.write_constants(item.stamp);
  switch (item.kind) {
    case StreamItem::Kind::kSamples:
      for (size_t k = 0; k < item.samples.size(); ++k)
        messages_.write_sample(item.samples[k], item.from_bus[k] != 0);
      return;
    case StreamItem::Kind::kImage:
      return write_image(item);
    case StreamItem::Kind::kSweep:
      return messages_.write_sweep(item.lidar, item.sweep, end_of(item.sweep));
    case StreamItem::Kind::kDatagrams:
      return for_each_datagram(item.datagrams, [&](Stamp stamp, std::span<const uint8_t> bytes) {
        messages_.add_datagram(item.lidar, bytes, stamp);
      });
    case StreamItem::Kind::kTick:
      return sink_.end_second();
    case StreamItem::Kind::kStart:
    case StreamItem::Kind::kFlush:
    case StreamItem::Kind::kEnd:
      return;
  }
}

void MessageStream::write_image(const StreamItem& item) {
  if (item.camera >= setup_.rig.cameras.size()) return;
  if (!item.raw) {
    return messages_.write_image(
        item.camera, {item.encoded, is_png(item.encoded), setup_.mosaics[item.camera]}, item.stamp);
  }
  const CameraTopics topics(setup_.rig.cameras[item.camera].name);
  if (!sink_.wants(topics.image) && !sink_.wants(topics.info)) return;
  camera::RawImage raw = item.raw->raw;
  raw.bytes = item.encoded;
  const auto file = encode_image_file(raw);
  if (!file) {
    ++unreadable_images_;
    return;
  }
  messages_.write_image(item.camera, {file->bytes, is_png(file->bytes), file->mosaic}, item.stamp);
}

bool MessageStream::read_sweeps() {
  sink_.begin_lane(MessageSink::Lane::kSweeps);
  bool any = false;
  while (true) {
    std::unique_ptr<SweepCopy> copy;
    {
      const std::lock_guard lock(mutex_);
      if (sweeps_.empty()) return any;
      copy = std::move(sweeps_.front());
      sweeps_.pop_front();
    }
    any = true;
    if (!copy->lidar) {
      sink_.end_second();
      continue;
    }
    messages_.write_deskewed(*copy->lidar, copy->sweep, copy->reference);
    copy->lidar.reset();
    const std::lock_guard lock(mutex_);
    if (unused_.size() < kMaxSweepCopies) unused_.push_back(std::move(copy));
  }
}

bool MessageStream::read_reports() {
  sink_.begin_lane(MessageSink::Lane::kReports);
  bool any = false;
  while (true) {
    std::pair<ReportClass, std::string> report;
    {
      const std::lock_guard lock(mutex_);
      if (reports_.empty()) return any;
      report = std::move(reports_.front());
      reports_.pop_front();
    }
    any = true;
    static_cast<void>(report_messages_.write(report.second));
    if (report.first == ReportClass::kHealth) sink_.end_second();  // one for each second
  }
}

}  // namespace infuse::daemon
