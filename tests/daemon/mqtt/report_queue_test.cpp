#include "daemon/mqtt/report_queue.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <fstream>
#include <optional>
#include <vector>

#include "tests/faults/disk_fault.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

constexpr uint64_t kBytes = 1 << 20;

QueuedReport report(const std::string& payload, int importance = 0) {
  return {.importance = importance, .topic = "infuse/car/health", .payload = payload};
}

std::vector<std::string> payloads(ReportQueue&& queue) {
  std::vector<std::string> all;
  int64_t id = 0;
  while (const auto next = queue.next_after(id)) {
    all.push_back(next->payload);
    id = next->id;
  }
  return all;
}

std::vector<std::string> payloads(ReportQueue& queue) { return payloads(std::move(queue)); }

TEST(ReportQueue, GivesReportsInOrderUntilTheyAreRemoved) {
  ReportQueue queue("", kBytes);
  EXPECT_FALSE(queue.next_after(0));
  for (const char* text : {"one", "two", "three"}) ASSERT_TRUE(queue.add(report(text)));
  EXPECT_EQ(payloads(queue), (std::vector<std::string>{"one", "two", "three"}));
  queue.remove(queue.next_after(0)->id);
  EXPECT_EQ(payloads(queue), (std::vector<std::string>{"two", "three"}));
  EXPECT_EQ(queue.messages(), 2u);
  EXPECT_EQ(queue.bytes(), 2 * 17 + 3 + 5u);
  queue.remove(4711);  // not there
  EXPECT_EQ(queue.messages(), 2u);
}

TEST(ReportQueue, KeepsBytesAsTheyAre) {
  ReportQueue queue("", kBytes);
  const std::string bytes("a\0b\xff\n\"", 6);
  QueuedReport given{.importance = 3, .topic = "t/\xc3\xbc", .payload = bytes, .retain = true};
  ASSERT_TRUE(queue.add(given));
  const auto found = queue.next_after(0);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->payload, bytes);
  EXPECT_EQ(found->topic, given.topic);
  EXPECT_TRUE(found->retain);
  EXPECT_EQ(found->importance, 3);
}

TEST(ReportQueue, OutlivesTheProcess) {
  const ScratchFolder folder;
  const auto path = folder.path() / "mqtt.db";
  int64_t last = 0;
  {
    ReportQueue queue(path, kBytes);
    for (const char* text : {"one", "two"}) ASSERT_TRUE(queue.add(report(text)));
    last = queue.next_after(queue.next_after(0)->id)->id;
    queue.remove(last);
  }
  ReportQueue queue(path, kBytes);
  EXPECT_EQ(queue.damage(), "");
  EXPECT_EQ(queue.messages(), 1u);
  EXPECT_EQ(queue.bytes(), 17 + 3u);
  EXPECT_EQ(payloads(queue), (std::vector<std::string>{"one"}));
  ASSERT_TRUE(queue.add(report("three")));
  EXPECT_GT(queue.next_after(queue.next_after(0)->id)->id, last);  // no number comes twice
}

TEST(ReportQueue, DropsTheOldestOfTheLeastImportantAndCounts) {
  const ScratchFolder folder;
  ReportQueue queue(folder.path() / "mqtt.db", kBytes);
  const std::string filler(10'000, 'x');
  ASSERT_TRUE(queue.add(report("alert", 3)));
  for (int k = 0; k < 1000; ++k) {
    ASSERT_TRUE(queue.add(report(std::to_string(k) + filler, k % 2)));
    ASSERT_LE(queue.bytes(), kBytes);
  }
  EXPECT_EQ(queue.dropped() + queue.messages(), 1001u);
  const auto left = payloads(queue);
  EXPECT_EQ(left.front(), "alert");
  EXPECT_EQ(left.back(), "999" + filler);
  // Only of the more important kind, the newest of them; the last pose came when nothing was less.
  for (size_t k = 1; k < left.size(); ++k) {
    EXPECT_EQ(left[k], std::to_string(999 - 2 * (left.size() - 1 - k)) + filler);
  }
  uint64_t on_disk = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder.path())) {
    on_disk += file.file_size();
  }
  EXPECT_LT(on_disk, 8 * kBytes);
  EXPECT_FALSE(queue.add(report(std::string(2 * kBytes, 'x'))));  // larger than the queue
  EXPECT_EQ(queue.messages(), left.size());
}

TEST(ReportQueue, SetsADamagedFileAside) {
  const ScratchFolder folder;
  const auto path = folder.path() / "mqtt.db";
  std::ofstream(path) << std::string(8192, 'q');
  ReportQueue queue(path, kBytes);
  EXPECT_NE(queue.damage().find("mqtt.db.damaged"), std::string::npos) << queue.damage();
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "mqtt.db.damaged"));
  EXPECT_TRUE(queue.add(report("one")));
}

TEST(ReportQueue, SetsTheFileOfANewerVersionAside) {
  const ScratchFolder folder;
  const auto path = folder.path() / "mqtt.db";
  ASSERT_TRUE(ReportQueue(path, kBytes).add(report("one")));
  // The version is the big-endian number at byte 60 (sqlite.org/fileformat2.html).
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(60).write("\0\0\0\2", 4);
  file.close();
  ReportQueue queue(path, kBytes);
  EXPECT_NE(queue.damage().find("newer version"), std::string::npos) << queue.damage();
  EXPECT_EQ(queue.messages(), 0u);
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "mqtt.db.damaged"));
}

TEST(ReportQueue, ASecondDamagedFileDoesNotReplaceTheFirst) {
  const ScratchFolder folder;
  for (const char* text : {"first", "second"}) {
    folder.write("mqtt.db", text + std::string(8192, 'q'));
    EXPECT_NE(ReportQueue(folder / "mqtt.db", kBytes).damage(), "");
  }
  EXPECT_EQ(folder.read("mqtt.db.damaged").substr(0, 5), "first");
  EXPECT_EQ(folder.read("mqtt.db.damaged.1").substr(0, 6), "second");
}

/// A disk that cannot be written, by its error.
class ReportQueueDisk : public testing::TestWithParam<int> {
 protected:
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const auto& file : std::filesystem::directory_iterator(folder_.path())) {
      names.push_back(file.path().filename());
    }
    return names;
  }

  const ScratchFolder folder_;
  const std::filesystem::path path_ = folder_ / "mqtt.db";
};

TEST_P(ReportQueueDisk, AtTheStartLeavesTheFileAndWaitsInMemory) {
  ASSERT_TRUE(ReportQueue(path_, kBytes).add(report("before")));
  std::optional<DiskFault> fault(std::in_place, folder_.path(), GetParam());
  ReportQueue queue(path_, kBytes);
  EXPECT_EQ(queue.damage(), "");
  EXPECT_NE(queue.disk_problem(), "");
  ASSERT_TRUE(queue.add(report("during")));
  EXPECT_EQ(payloads(queue).back(), "during");
  EXPECT_FALSE(queue.try_file());
  fault.reset();
  EXPECT_TRUE(queue.try_file() || queue.disk_problem().empty());
  EXPECT_EQ(queue.disk_problem(), "");
  EXPECT_EQ(payloads(queue), (std::vector<std::string>{"before", "during"}));
  EXPECT_THAT(names(), Not(Contains(HasSubstr("damaged"))));
}

TEST_P(ReportQueueDisk, WhileItRunsLosesNothing) {
  std::vector<std::string> all;
  const auto add = [&](ReportQueue& queue, int first) {
    for (int k = first; k < first + 40; ++k) {
      all.push_back(std::to_string(k) + std::string(10'000, 'x'));
      ASSERT_TRUE(queue.add(report(all.back())));
    }
  };
  ReportQueue queue(path_, 64 * kBytes);
  add(queue, 0);
  const auto first = queue.next_after(0);
  {
    const DiskFault fault(folder_.path(), GetParam());
    add(queue, 40);
    EXPECT_NE(queue.disk_problem(), "");
    queue.remove(first->id);  // the broker has it
    const auto later = queue.next_after(first->id);
    ASSERT_TRUE(later);
    EXPECT_EQ(later->payload.substr(0, 2), "40");  // from memory
  }
  EXPECT_TRUE(queue.try_file());
  EXPECT_EQ(queue.dropped(), 0u);
  all.erase(all.begin());
  EXPECT_EQ(payloads(queue), all);
  EXPECT_EQ(payloads(ReportQueue(path_, 64 * kBytes)), all);
}

TEST_P(ReportQueueDisk, AnOlderMessageDoesNotReplaceANewerOneAtTheBroker) {
  QueuedReport alert = report("raised");
  alert.retain = true;
  ASSERT_TRUE(ReportQueue(path_, kBytes).add(alert));
  std::optional<DiskFault> fault(std::in_place, folder_.path(), GetParam());
  ReportQueue queue(path_, kBytes);
  alert.payload = "cleared";
  ASSERT_TRUE(queue.add(alert));
  const auto last = queue.next_after(0);
  ASSERT_TRUE(last);
  if (!queue.disk_problem().empty()) queue.remove(last->id);  // published from memory
  fault.reset();
  queue.try_file();
  const auto first = queue.next_after(0);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->payload, "raised");
  EXPECT_FALSE(first->retain);
}

TEST(ReportQueue, InMemoryItIsBoundedToo) {
  ReportQueue queue("", kBytes);
  for (int k = 0; k < 300; ++k) ASSERT_TRUE(queue.add(report(std::string(10'000, 'x'), k % 2)));
  EXPECT_LE(queue.bytes(), kBytes);
  EXPECT_EQ(queue.messages() + queue.dropped(), 300u);
  EXPECT_EQ(payloads(queue).size(), queue.messages());
}

INSTANTIATE_TEST_SUITE_P(All, ReportQueueDisk, testing::Values(ENOSPC, EIO, EROFS));

}  // namespace
}  // namespace infuse::daemon
