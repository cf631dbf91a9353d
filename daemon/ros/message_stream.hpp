#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "daemon/pipeline/pipeline_tap.hpp"
#include "daemon/pipeline/stream_item.hpp"
#include "daemon/protocol/reports.hpp"
#include "daemon/ros/report_messages.hpp"
#include "daemon/ros/sensor_messages.hpp"
#include "drivers/measurement/slot_ring.hpp"

namespace infuse::daemon {

/// Turns what passes through a pipeline into messages, on a thread of its own: what the io thread
/// has read (a reader of the ring of items), deskewed sweeps of the fusion thread, and reports.
/// Nothing is made that no sink wants. Live, no thread of the pipeline waits for this one: what it
/// does not read in time is dropped and counted. In a replay nothing is dropped.
class MessageStream : public PipelineTap {
 public:
  /// The sinks outlive this. A live stream sleeps while `wanted` returns false; it is
  /// called on the stream's thread, after each `wake`.
  MessageStream(
      const MessageSetup& setup, std::vector<MessageSink*> sinks,
      std::function<bool()> wanted = [] { return true; });
  ~MessageStream() override { finish(); }

  /// Registers as a reader of `items` and starts the thread; before the pipeline starts.
  void start(SlotRing<StreamItem>& items);

  /// The need may have changed; from any thread.
  void wake();

  /// Adds a report, a line of JSON; on the publisher's thread.
  void add_report(ReportClass report_class, const std::string& line);

  /// Writes what waits and ends the thread; when the pipeline has ended, before it is destroyed.
  void finish();

  /// Numbers of items, sweeps and reports that were dropped, live.
  uint64_t lost() const;

  /// Sweeps that wait, and what was dropped, for HEALTH.
  QueueStats stats() const;

  /// Appends what was not written; after `finish`.
  void append_notes(std::vector<Error>& notes) const;

  bool wants_datagrams(LidarIndex lidar) const override;
  void add_sweep(const SweepSnapshot& snapshot) override;
  void end_second() override;

 private:
  /// A sweep as of `reference`; without a lidar: the end of a second.
  struct SweepCopy {
    std::optional<LidarIndex> lidar;
    Stamp reference;
    Sweep sweep;
  };
  /// All sinks as one.
  class Tee : public MessageSink {
   public:
    explicit Tee(std::vector<MessageSink*> sinks) : sinks_(std::move(sinks)) {}
    bool wants(const std::string& topic) const override;
    void add(const std::string& topic, const char* type, Stamp log_time, bool latched,
             std::span<const uint8_t> bytes) override;
    void begin_lane(Lane lane) override;
    void end_second() override;

   private:
    std::vector<MessageSink*> sinks_;
  };

  void run(const std::stop_token& stop);
  bool sleep_until_wanted(const std::stop_token& stop);
  bool read_items();
  bool read_sweeps();
  bool read_reports();
  void write_item(const StreamItem& item);
  void write_image(const StreamItem& item);
  std::unique_ptr<SweepCopy> unused_copy();
  void push_copy(std::unique_ptr<SweepCopy> copy);

  const MessageSetup setup_;
  Tee sink_;
  ReportMessages report_messages_{sink_};
  std::function<bool()> wanted_;
  SensorMessages messages_;
  std::vector<LidarTopics> lidar_topics_;
  bool started_ = false;  // the transforms are written
  size_t unreadable_images_ = 0;

  std::optional<SlotRing<StreamItem>::Reader> items_;
  std::atomic<uint64_t> lost_items_{0}, lost_sweeps_{0}, lost_reports_{0};
  uint64_t lost_before_ = 0;  // items that passed while nobody wanted any
  std::atomic<bool> asleep_{false};

  mutable std::mutex mutex_;  // guards what follows
  std::condition_variable_any wake_;
  std::deque<std::unique_ptr<SweepCopy>> sweeps_;
  std::vector<std::unique_ptr<SweepCopy>> unused_;
  std::deque<std::pair<ReportClass, std::string>> reports_;

  std::jthread thread_;
};

}  // namespace infuse::daemon
