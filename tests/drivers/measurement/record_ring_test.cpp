#include "drivers/measurement/record_ring.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <random>
#include <thread>
#include <vector>

#include "drivers/measurement/vehicle_samples.hpp"

namespace infuse {
namespace {

using namespace std::chrono_literals;

Stamp at(int64_t ns) { return Stamp::from_ns(ns); }

/// A record of 6½ words whose every part follows from its number, so that a torn copy shows.
struct Sample {
  Stamp stamp;
  uint64_t number = 0;
  std::array<uint32_t, 9> echo{};

  static Sample make(uint64_t number, Stamp stamp) {
    Sample sample{.stamp = stamp, .number = number};
    for (size_t i = 0; i < sample.echo.size(); ++i) sample.echo[i] = scramble(number, i);
    return sample;
  }
  static uint32_t scramble(uint64_t number, size_t i) {
    return static_cast<uint32_t>((number * 9 + i + 1) * 0x9E3779B97F4A7C15u >> 32);
  }
  bool is_intact() const {
    for (size_t i = 0; i < echo.size(); ++i) {
      if (echo[i] != scramble(number, i)) return false;
    }
    return true;
  }
};

/// What the ring must do, said as plainly as possible.
class Model {
 public:
  struct Reader {
    uint64_t cursor = 0;
    uint64_t lost = 0;
  };

  explicit Model(size_t capacity) : capacity_(capacity) {}

  void push(const Sample& sample) {
    entries_.push_back(sample);
    if (entries_.size() > capacity_) entries_.pop_front();
    ++pushed_;
  }
  uint64_t oldest() const { return pushed_ - entries_.size(); }
  Reader reader() const { return {.cursor = pushed_, .lost = 0}; }
  std::optional<Sample> next(Reader& reader) const {
    if (reader.cursor < oldest()) {
      reader.lost += oldest() - reader.cursor;
      reader.cursor = oldest();
    }
    if (reader.cursor == pushed_) return std::nullopt;
    return entries_[reader.cursor++ - oldest()];
  }
  std::optional<Sample> nearest(Stamp stamp) const {
    std::optional<Sample> best;
    for (const Sample& sample : entries_) {
      if (!best || std::chrono::abs(sample.stamp - stamp) <= std::chrono::abs(best->stamp - stamp))
        best = sample;
    }
    return best;
  }
  std::vector<uint64_t> interval(Stamp from, Stamp to) const {
    std::vector<uint64_t> numbers;
    for (const Sample& sample : entries_) {
      if (sample.stamp >= from && sample.stamp <= to) numbers.push_back(sample.number);
    }
    return numbers;
  }
  bool has_room(const std::vector<Reader>& readers) const {
    return std::all_of(readers.begin(), readers.end(), [&](const Reader& reader) {
      return entries_.size() < capacity_ || reader.cursor > oldest();
    });
  }
  std::deque<Sample> entries_;
  uint64_t pushed_ = 0;

 private:
  size_t capacity_;
};

void expect_same(const std::optional<Sample>& found, const std::optional<Sample>& expected) {
  ASSERT_EQ(found.has_value(), expected.has_value());
  if (!found) return;
  EXPECT_EQ(found->number, expected->number);
  EXPECT_EQ(found->stamp, expected->stamp);
  EXPECT_TRUE(found->is_intact());
}

/// Random operations on the ring and on the model; everything that can be seen must be equal.
void compare_with_model(size_t capacity, uint32_t seed, bool ordered_stamps) {
  std::mt19937 random(seed);
  const auto random_below = [&](uint32_t n) { return static_cast<int64_t>(random() % n); };
  RecordRing<Sample> ring(capacity);
  ASSERT_EQ(ring.capacity(), capacity);
  Model model(capacity);
  std::vector<RecordRing<Sample>::Reader> readers;
  std::vector<Model::Reader> model_readers;
  int64_t time = 0;
  for (int step = 0; step < 20'000; ++step) {
    const auto random_stamp = [&] {
      return at(time - random_below(uint32_t(capacity) * 12 + 20) + 10);
    };
    switch (random_below(12)) {
      case 0:
      case 1:
      case 2: {
        for (int64_t burst = random_below(8) == 0 ? random_below(uint32_t(capacity) * 3) : 1;
             burst > 0; --burst) {
          time += random_below(10);
          const Stamp stamp = at(ordered_stamps ? time : time - random_below(30));
          const Sample sample = Sample::make(model.pushed_, stamp);
          ring.push(sample);
          model.push(sample);
        }
        break;
      }
      case 3: {
        if (readers.size() < 5) {
          readers.push_back(ring.make_reader());
          model_readers.push_back(model.reader());
        } else if (random_below(20) == 0) {
          const auto which = random_below(uint32_t(readers.size()));
          readers.erase(readers.begin() + which);
          model_readers.erase(model_readers.begin() + which);
        }
        break;
      }
      case 4:
      case 5:
      case 6:
      case 7: {
        if (readers.empty()) break;
        const auto which = static_cast<size_t>(random_below(uint32_t(readers.size())));
        for (int64_t n = random_below(uint32_t(capacity) + 2); n >= 0; --n) {
          expect_same(readers[which].next(), model.next(model_readers[which]));
          ASSERT_EQ(readers[which].lost(), model_readers[which].lost);
          ASSERT_EQ(readers[which].backlog(), model.pushed_ - model_readers[which].cursor);
        }
        break;
      }
      case 8: {
        expect_same(ring.latest(),
                    model.entries_.empty() ? std::nullopt : std::optional(model.entries_.back()));
        break;
      }
      case 9: {
        const Stamp stamp = random_stamp();
        expect_same(ring.nearest(stamp), model.nearest(stamp));
        break;
      }
      case 10: {
        const Stamp from = random_stamp();
        const Stamp to = from + Duration(random_below(60));
        const std::vector<uint64_t> expected = model.interval(from, to);
        std::vector<uint64_t> found;
        const IntervalResult result = ring.visit_interval(from, to, [&](const Sample& sample) {
          EXPECT_TRUE(sample.is_intact());
          found.push_back(sample.number);
        });
        ASSERT_EQ(found, expected);
        ASSERT_EQ(result.count, expected.size());
        if (ordered_stamps) {
          ASSERT_EQ(result.complete, model.oldest() == 0 || model.entries_.front().stamp < from);
        }
        std::array<Sample, 3> first{};
        ASSERT_EQ(ring.copy_interval(from, to, first).count, expected.size());
        for (size_t i = 0; i < std::min<size_t>(3, expected.size()); ++i) {
          ASSERT_EQ(first[i].number, expected[i]);
        }
        break;
      }
      default: {
        ASSERT_EQ(ring.has_room(), model.has_room(model_readers));
        ASSERT_EQ(ring.published(), model.pushed_);
      }
    }
  }
}

TEST(RecordRing, DoesWhatALockedDequeDoes) {
  for (const size_t capacity : {1u, 2u, 4u, 16u}) {
    for (uint32_t seed = 0; seed < 4; ++seed) {
      ASSERT_NO_FATAL_FAILURE(compare_with_model(capacity, seed, seed % 2 == 0));
    }
  }
}

TEST(RecordRing, RoundsItsCapacityUpAndRefusesNone) {
  EXPECT_EQ(RecordRing<ImuSample>(5).capacity(), 8u);
  EXPECT_EQ(RecordRing<GnssFix>(8).capacity(), 8u);
  EXPECT_THROW(RecordRing<ImuSample>(0), std::invalid_argument);
}

TEST(RecordRing, KeepsEveryBitOfARecord) {
  RecordRing<GnssFix> ring(2);
  const GnssFix fix{.stamp = at(5),
                    .latitude = 0.25,
                    .longitude = -1.5,
                    .altitude = -0.0,
                    .speed = 3,
                    .course = 4,
                    .hdop = 5,
                    .utc_ns = INT64_MIN,
                    .valid = true};
  ring.push(fix);
  const GnssFix found = ring.latest().value();
  EXPECT_EQ(found.stamp, fix.stamp);
  EXPECT_EQ(found.longitude, fix.longitude);
  EXPECT_TRUE(std::signbit(found.altitude));
  EXPECT_EQ(found.utc_ns, fix.utc_ns);
  EXPECT_TRUE(found.valid);
}

TEST(RecordRing, ExtremeStampsAreFound) {
  RecordRing<Sample> ring(4);
  ring.push(Sample::make(0, Stamp::earliest()));
  ring.push(Sample::make(1, Stamp::latest()));
  EXPECT_EQ(ring.nearest(Stamp::earliest())->number, 0u);
  EXPECT_EQ(ring.nearest(Stamp::latest())->number, 1u);
  std::array<Sample, 2> all{};
  EXPECT_EQ(ring.copy_interval(Stamp::earliest(), Stamp::latest(), all).count, 2u);
}

TEST(RecordRing, HasSixteenReadersAtMost) {
  RecordRing<ImuSample> ring(2);
  std::vector<RecordRing<ImuSample>::Reader> readers;
  for (size_t i = 0; i < RingCore::kMaxReaders; ++i) readers.push_back(ring.make_reader());
  EXPECT_THROW(ring.make_reader(), std::length_error);
  readers.pop_back();
  EXPECT_NO_THROW(ring.make_reader());
}

TEST(RecordRing, WaitingEndsWithTheTimeOrTheRing) {
  RecordRing<ImuSample> ring(2);
  auto reader = ring.make_reader();
  EXPECT_FALSE(reader.wait(1ms));
  ring.push({});
  EXPECT_TRUE(reader.wait(0ms));
  ring.push({});
  EXPECT_FALSE(ring.wait_for_room(1ms));
  std::thread closer([&] { ring.close(); });
  EXPECT_FALSE(ring.wait_for_room());
  closer.join();
  EXPECT_TRUE(reader.wait());  // what is held can still be read
  EXPECT_TRUE(reader.next());
  EXPECT_TRUE(reader.next());
  EXPECT_FALSE(reader.wait());
  EXPECT_EQ(reader.lost(), 0u);
}

TEST(RecordRing, OneSignalWakesForSeveralRings) {
  EventCount arrivals;
  RecordRing<ImuSample> imu(4, &arrivals);
  RecordRing<WheelOdometry> wheels(4, &arrivals);
  auto imu_reader = imu.make_reader();
  auto wheel_reader = wheels.make_reader();
  std::thread producer([&] {
    for (int i = 0; i < 500; ++i) {
      imu.wait_for_room();
      imu.push({});
      wheels.wait_for_room();
      wheels.push({});
    }
    imu.close();
    wheels.close();
  });
  int found = 0;
  while (true) {
    arrivals.wait([&] {
      return imu_reader.backlog() + wheel_reader.backlog() > 0 || (imu.closed() && wheels.closed());
    });
    if (imu_reader.backlog() + wheel_reader.backlog() == 0) break;
    while (imu_reader.next()) ++found;
    while (wheel_reader.next()) ++found;
  }
  producer.join();
  EXPECT_EQ(found, 1000);
}

TEST(RecordRing, LiveReadersSeeIntactRecordsInOrderAndCountLostOnes) {
  constexpr uint64_t kRecords = 200'000;
  RecordRing<Sample> ring(8);
  std::atomic<uint64_t> torn{0};
  std::vector<std::thread> threads;
  std::array<uint64_t, 3> read{}, lost{};
  for (size_t id = 0; id < read.size(); ++id) {
    threads.emplace_back([&, id, reader = ring.make_reader()]() mutable {
      uint64_t expected = 0;
      while (reader.wait()) {
        while (const auto sample = reader.next()) {
          expected = ++read[id] + reader.lost();
          if (!sample->is_intact() || sample->number + 1 != expected) ++torn;
          if (id == 0 && read[id] % 64 == 0) std::this_thread::yield();
        }
      }
      lost[id] = reader.lost();
    });
  }
  threads.emplace_back([&] {
    uint64_t last = 0;
    while (!ring.closed()) {
      if (const auto sample = ring.latest()) {
        if (!sample->is_intact() || sample->number < last) ++torn;
        last = sample->number;
      }
      const Stamp middle = at(static_cast<int64_t>(last));
      if (const auto sample = ring.nearest(middle); sample && !sample->is_intact()) ++torn;
      uint64_t before = 0;
      ring.visit_interval(middle - Duration(3), middle + Duration(3), [&](const Sample& sample) {
        if (!sample.is_intact() || sample.number < before) ++torn;
        before = sample.number;
      });
    }
  });
  for (uint64_t number = 0; number < kRecords; ++number) {
    ring.push(Sample::make(number, at(static_cast<int64_t>(number))));
  }
  ring.close();
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(torn, 0u);
  for (size_t id = 0; id < read.size(); ++id) EXPECT_EQ(read[id] + lost[id], kRecords);
}

TEST(RecordRing, AReplayThatWaitsForRoomLosesNothing) {
  constexpr uint64_t kRecords = 50'000;
  RecordRing<Sample> ring(4);
  std::atomic<uint64_t> wrong{0};
  std::vector<std::thread> threads;
  for (int id = 0; id < 2; ++id) {
    threads.emplace_back([&, reader = ring.make_reader()]() mutable {
      uint64_t expected = 0;
      while (reader.wait()) {
        while (const auto sample = reader.next()) {
          if (!sample->is_intact() || sample->number != expected++) ++wrong;
        }
      }
      if (expected != kRecords || reader.lost() != 0) ++wrong;
    });
  }
  for (uint64_t number = 0; number < kRecords; ++number) {
    ASSERT_TRUE(ring.wait_for_room());
    ring.push(Sample::make(number, at(static_cast<int64_t>(number))));
  }
  ring.close();
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace infuse
