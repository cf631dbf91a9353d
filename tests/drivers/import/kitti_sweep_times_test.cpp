#include "drivers/import/kitti_sweep_times.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/import/kitti_exposures.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::importers {
namespace {

using ::testing::HasSubstr;

// Stamps of the given seconds after 13:00:00; negative: an empty line.
std::string stamps(const std::vector<double>& seconds) {
  std::string text;
  for (const double s : seconds) {
    if (s >= 0) text += "2011-09-26 13:00:0" + std::to_string(s);
    text += "\n";
  }
  return text;
}

class KittiTurnTimes : public ::testing::Test {
 protected:
  void write(const char* which, const std::vector<double>& seconds) {
    folder_.write(std::string("timestamps") + which + ".txt", stamps(seconds));
  }
  void SetUp() override {
    write("_start", {1.0, 1.1, 1.2, 1.3});
    write("", {1.05, 1.15, 1.25, 1.35});
    write("_end", {1.1, 1.2, 1.3, 1.4});
  }
  // Numbers of the turns that have times.
  std::string usable() {
    notes_.clear();
    const auto turns = read_kitti_turn_times(folder_.path(), notes_);
    if (!turns) return turns.error().message();
    std::string numbers;
    for (size_t k = 0; k < turns->size(); ++k) {
      if (!(*turns)[k]) continue;
      numbers += std::to_string(k);
      EXPECT_NEAR(to_seconds((*turns)[k]->middle - (*turns)[k]->start), 0.05, 1e-6) << k;
      EXPECT_NEAR(to_seconds((*turns)[k]->end - (*turns)[k]->middle), 0.05, 1e-6) << k;
      EXPECT_NEAR(static_cast<double>((*turns)[k]->start.ns() % 10'000'000'000) * 1e-9,
                  1 + 0.1 * static_cast<double>(k), 1e-6);
    }
    return numbers;
  }
  std::string notes() const {
    std::string text;
    for (const Error& note : notes_) text += note.message() + "\n";
    return text;
  }

  ScratchFolder folder_;
  std::vector<Error> notes_;
};

TEST_F(KittiTurnTimes, LineKBelongsToTurnKThoughLinesAreEmpty) {
  EXPECT_EQ(usable(), "0123");
  EXPECT_EQ(notes(), "");
  for (const char* which : {"_start", "", "_end"}) {
    const double first = *which == '\0' ? 1.05 : which[1] == 's' ? 1.0 : 1.1;
    write(which, {first, -1, -1, first + 0.3});
  }
  EXPECT_EQ(usable(), "03");
  EXPECT_EQ(notes(), "") << "a missing sweep is no problem";
}

TEST_F(KittiTurnTimes, AShorterFileIsNoted) {
  write("_end", {1.1, 1.2});
  EXPECT_EQ(usable(), "01");
  EXPECT_THAT(notes(), HasSubstr("not all stamps of a turn are given"));
  EXPECT_THAT(notes(), HasSubstr("2 such sweeps are skipped"));
}

TEST_F(KittiTurnTimes, WrongTurnsAreNotedWithTheirLine) {
  write("", {1.05, 1.25, 1.25, 1.35});
  EXPECT_EQ(usable(), "023");
  EXPECT_THAT(notes(), HasSubstr("timestamps.txt:2: the middle is not between start and end"));
  SetUp();
  write("_end", {1.1, 1.2, 1.1, 1.4});
  EXPECT_EQ(usable(), "013");
  EXPECT_THAT(notes(), HasSubstr("timestamps_end.txt:3: the end is not within a second"));
}

TEST_F(KittiTurnTimes, ATurnBeforeItsPredecessorIsNoted) {
  folder_.write("timestamps_start.txt", stamps({1.0, 1.1, 0.9, 1.3}));
  folder_.write("timestamps.txt", stamps({1.05, 1.15, 0.95, 1.35}));
  folder_.write("timestamps_end.txt", stamps({1.1, 1.2, 1.0, 1.4}));
  EXPECT_EQ(usable(), "013");
  EXPECT_THAT(notes(), HasSubstr("timestamps_start.txt:3: the turn starts before the one before"));
}

TEST_F(KittiTurnTimes, MissingFilesAreReplacedWhereTheyCanBe) {
  std::filesystem::remove(folder_ / "timestamps.txt");
  EXPECT_EQ(usable(), "0123");
  EXPECT_THAT(notes(), HasSubstr("half way from its start to its end"));
  SetUp();
  std::filesystem::remove(folder_ / "timestamps_end.txt");
  EXPECT_EQ(usable(), "0123");
  EXPECT_THAT(notes(), HasSubstr("each turn is taken as centred on its stamp"));
  std::filesystem::remove(folder_ / "timestamps.txt");
  EXPECT_THAT(usable(), HasSubstr("has no stamps of the sweeps"));
}

std::vector<std::optional<TurnTimes>> make_turns(size_t count) {
  std::vector<std::optional<TurnTimes>> turns;
  for (size_t k = 0; k < count; ++k) {
    const Stamp start = Stamp() + Duration(100'000'000) * k;
    turns.push_back(TurnTimes{start, start + Duration(50'000'000), start + Duration(100'000'000)});
  }
  return turns;
}

// Images 10 to 19 ms after the middles of their turns, and `offset` later.
std::vector<StampedFile> make_images(size_t count, Duration offset) {
  std::vector<StampedFile> images;
  for (size_t k = 0; k < count; ++k) {
    const Duration delay(10'000'000 + static_cast<int64_t>(k % 10) * 1'000'000);
    const Stamp middle = Stamp() + Duration(100'000'000) * k + Duration(50'000'000);
    images.push_back({{.stamp = middle + delay + offset}, "", k});
  }
  return images;
}

TEST(KittiExposures, FollowTheMiddlesOfTheTurns) {
  auto turns = make_turns(40);
  turns[7].reset();
  auto images = make_images(40, {});
  const auto exposures = find_exposures("image_00", turns, images);
  ASSERT_TRUE(exposures) << exposures.error().message();
  EXPECT_NEAR(to_seconds(exposures->delay), 0.0115, 0.0011);
  EXPECT_EQ(exposures->sigma, Duration(3'000'000));
  EXPECT_THAT(exposures->note.message(), HasSubstr("10 ms to 19 ms after"));
  EXPECT_EQ(images[3].times.exposure, turns[3]->middle + Duration(3'000'000));
  EXPECT_FALSE(images[7].times.exposure) << "its turn is missing";
}

TEST(KittiExposures, StampsThatDoNotFollowTheTurnsAreLeftAsTheyAre) {
  const auto turns = make_turns(40);
  auto images = make_images(40, Duration(70'000'000));
  const auto exposures = find_exposures("image_00", turns, images);
  ASSERT_TRUE(exposures);
  EXPECT_EQ(exposures->delay, Duration::zero());
  EXPECT_FALSE(images[0].times.exposure);
  EXPECT_THAT(exposures->note.message(), HasSubstr("do not follow the sweeps"));
}

TEST(KittiExposures, AnotherTimeZoneIsAnError) {
  auto images = make_images(40, std::chrono::hours(2));
  const auto exposures = find_exposures("image_00", make_turns(40), images);
  ASSERT_FALSE(exposures);
  EXPECT_THAT(exposures.error().message(), HasSubstr("7200 s after those of the sweeps"));
  EXPECT_THAT(exposures.error().message(), HasSubstr("time zone"));
}

}  // namespace
}  // namespace infuse::importers
