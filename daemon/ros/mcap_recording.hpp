#pragma once

#include <array>
#include <atomic>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "daemon/ros/message_setup.hpp"
#include "daemon/ros/ros_file.hpp"

namespace infuse::daemon {

/// The file of `infused --mcap`: what `infuse export mcap --deskew` writes of a drive. Chunks have
/// at most a second and are given to the kernel at once, so that a file which is cut, or whose
/// process is killed, is readable to its last chunk.
///
/// Live, messages are in the order in which they came. Of a replay the file is the same every time:
/// a second of drive time is written when all lanes have passed it, by log time.
class McapRecording : public MessageSink {
 public:
  static Result<std::unique_ptr<McapRecording>> create(const std::filesystem::path& path,
                                                       const MessageSetup& setup);

  /// False for the measured cloud of a lidar whose packets are written, and after an error.
  bool wants(const std::string& topic) const override;
  void add(const std::string& topic, const char* type, Stamp log_time, bool latched,
           std::span<const uint8_t> bytes) override;
  void begin_lane(Lane lane) override { lane_ = static_cast<size_t>(lane); }
  void end_second() override;

  /// Writes what is held, the index and the summary.
  Result<void> close();

  /// Why nothing more is written; empty: the file is written. From any thread.
  std::string problem() const { return failed_ ? file_.error()->message() : ""; }

  /// Number of messages of each topic.
  const std::map<std::string, size_t>& messages() const { return file_.messages(); }

 private:
  struct Held {
    std::string topic;
    const char* type = "";
    Stamp log_time;
    bool latched = false;
    size_t lane = 0;
    std::vector<uint8_t> bytes;
  };
  McapRecording(RosFile file, const MessageSetup& setup);
  void write_first_second();
  void check();

  RosFile file_;
  const bool live_;
  std::set<std::string> refused_;  // topics
  std::atomic<bool> failed_{false};
  size_t lane_ = 0;
  std::array<uint64_t, kLanes> seconds_{};  // passed by each lane
  uint64_t written_ = 0;                    // seconds
  std::deque<std::vector<Held>> held_;      // by second, from `written_`
};

}  // namespace infuse::daemon
