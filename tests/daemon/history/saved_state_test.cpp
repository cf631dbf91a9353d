#include "daemon/history/saved_state.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

namespace infuse::daemon {
namespace {

TEST(SavedState, ReadsBackAsWritten) {
  SavedState state;
  state.starts = 7;
  state.unclean_exits = 3;
  state.running = true;
  state.saved_at = Stamp::from_ns(1'700'000'000'123'456'789);
  state.total_run_time = Duration(987'654'321);
  const auto back = parse_state(format_state(state));
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->starts, 7U);
  EXPECT_EQ(back->unclean_exits, 3U);
  EXPECT_TRUE(back->running);
  EXPECT_EQ(back->saved_at, state.saved_at);
  EXPECT_EQ(back->total_run_time, state.total_run_time);
}

TEST(SavedState, InvalidTextIsAnError) {
  const std::string good = format_state({});
  for (size_t length = 0; length + 2 < good.size(); ++length) {
    EXPECT_FALSE(parse_state(good.substr(0, length)).has_value()) << length;
  }
  EXPECT_FALSE(parse_state("[]").has_value());
  EXPECT_FALSE(parse_state(R"({"form":2})").has_value());
  EXPECT_FALSE(parse_state(R"({"form":1,"starts":-1})").has_value());
}

TEST(SavedState, AMissingFileIsNotAnErrorButADamagedOneIs) {
  const auto path =
      std::filesystem::path(testing::TempDir()) / ("infuse-state-" + std::to_string(getpid()));
  const auto none = read_state(path);
  ASSERT_TRUE(none.has_value());
  EXPECT_FALSE(none->has_value());
  std::ofstream(path) << "{";
  EXPECT_FALSE(read_state(path).has_value());
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace infuse::daemon
