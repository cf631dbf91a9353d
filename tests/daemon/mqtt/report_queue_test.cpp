#include "daemon/mqtt/report_queue.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <vector>

#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

constexpr uint64_t kBytes = 1 << 20;

QueuedReport report(const std::string& payload, int importance = 0) {
  return {.importance = importance, .topic = "infuse/car/health", .payload = payload};
}

std::vector<std::string> payloads(ReportQueue& queue) {
  std::vector<std::string> all;
  int64_t id = 0;
  while (const auto next = queue.next_after(id)) {
    all.push_back(next->payload);
    id = next->id;
  }
  return all;
}

TEST(ReportQueue, GivesReportsInOrderUntilTheyAreRemoved) {
  auto queue = ReportQueue::open("", kBytes);
  ASSERT_TRUE(queue) << queue.error().message();
  EXPECT_FALSE(queue->next_after(0));
  for (const char* text : {"one", "two", "three"}) ASSERT_TRUE(queue->add(report(text)));
  EXPECT_EQ(payloads(*queue), (std::vector<std::string>{"one", "two", "three"}));
  queue->remove(queue->next_after(0)->id);
  EXPECT_EQ(payloads(*queue), (std::vector<std::string>{"two", "three"}));
  EXPECT_EQ(queue->messages(), 2u);
  EXPECT_EQ(queue->bytes(), 2 * 17 + 3 + 5u);
  queue->remove(4711);  // not there
  EXPECT_EQ(queue->messages(), 2u);
}

TEST(ReportQueue, KeepsBytesAsTheyAre) {
  auto queue = ReportQueue::open("", kBytes);
  ASSERT_TRUE(queue);
  const std::string bytes("a\0b\xff\n\"", 6);
  QueuedReport given{.importance = 3, .topic = "t/\xc3\xbc", .payload = bytes, .retain = true};
  ASSERT_TRUE(queue->add(given));
  const auto found = queue->next_after(0);
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
    auto queue = ReportQueue::open(path, kBytes);
    ASSERT_TRUE(queue) << queue.error().message();
    for (const char* text : {"one", "two"}) ASSERT_TRUE(queue->add(report(text)));
    last = queue->next_after(queue->next_after(0)->id)->id;
    queue->remove(last);
  }
  auto queue = ReportQueue::open(path, kBytes);
  ASSERT_TRUE(queue) << queue.error().message();
  EXPECT_EQ(queue->damage(), "");
  EXPECT_EQ(queue->messages(), 1u);
  EXPECT_EQ(queue->bytes(), 17 + 3u);
  EXPECT_EQ(payloads(*queue), (std::vector<std::string>{"one"}));
  ASSERT_TRUE(queue->add(report("three")));
  EXPECT_GT(queue->next_after(queue->next_after(0)->id)->id, last);  // no number comes twice
}

TEST(ReportQueue, DropsTheOldestOfTheLeastImportantAndCounts) {
  const ScratchFolder folder;
  auto queue = ReportQueue::open(folder.path() / "mqtt.db", kBytes);
  ASSERT_TRUE(queue);
  const std::string filler(10'000, 'x');
  ASSERT_TRUE(queue->add(report("alert", 3)));
  for (int k = 0; k < 1000; ++k) {
    ASSERT_TRUE(queue->add(report(std::to_string(k) + filler, k % 2)));
    ASSERT_LE(queue->bytes(), kBytes);
  }
  EXPECT_EQ(queue->dropped() + queue->messages(), 1001u);
  const auto left = payloads(*queue);
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
  EXPECT_FALSE(queue->add(report(std::string(2 * kBytes, 'x'))));  // larger than the queue
  EXPECT_EQ(queue->messages(), left.size());
}

TEST(ReportQueue, SetsADamagedFileAside) {
  const ScratchFolder folder;
  const auto path = folder.path() / "mqtt.db";
  std::ofstream(path) << std::string(8192, 'q');
  auto queue = ReportQueue::open(path, kBytes);
  ASSERT_TRUE(queue) << queue.error().message();
  EXPECT_NE(queue->damage().find("mqtt.db.damaged"), std::string::npos) << queue->damage();
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "mqtt.db.damaged"));
  EXPECT_TRUE(queue->add(report("one")));
  EXPECT_FALSE(ReportQueue::open("/nonexistent/folder/mqtt.db", kBytes));
}

TEST(ReportQueue, SetsTheFileOfANewerVersionAside) {
  const ScratchFolder folder;
  const auto path = folder.path() / "mqtt.db";
  ASSERT_TRUE(ReportQueue::open(path, kBytes)->add(report("one")));
  // The version is the big-endian number at byte 60 (sqlite.org/fileformat2.html).
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(60).write("\0\0\0\2", 4);
  file.close();
  auto queue = ReportQueue::open(path, kBytes);
  ASSERT_TRUE(queue) << queue.error().message();
  EXPECT_NE(queue->damage().find("newer version"), std::string::npos) << queue->damage();
  EXPECT_EQ(queue->messages(), 0u);
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "mqtt.db.damaged"));
}

TEST(ReportQueue, AFullDiskDropsAndCounts) {
  const ScratchFolder folder;
  std::signal(SIGXFSZ, SIG_IGN);
  auto queue = ReportQueue::open(folder.path() / "mqtt.db", 64 * kBytes);
  ASSERT_TRUE(queue);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{1 << 20, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  uint64_t added = 0, refused = 0;
  for (int k = 0; k < 300; ++k) {
    (queue->add(report(std::string(10'000, 'x'))) ? added : refused) += 1;
  }
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_GT(queue->dropped(), 0u);
  EXPECT_EQ(queue->messages() + queue->dropped(), 300u) << added << " " << refused;
  EXPECT_EQ(payloads(*queue).size(), queue->messages());
  EXPECT_TRUE(queue->add(report("again")));
}

}  // namespace
}  // namespace infuse::daemon
