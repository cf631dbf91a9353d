#include "drivers/import/kitti_sweep_times.hpp"

#include <algorithm>

#include "drivers/import/kitti_files.hpp"

namespace infuse::importers {
namespace {

namespace fs = std::filesystem;

using Times = std::vector<std::optional<Stamp>>;

constexpr Duration kMaxTurn{1'000'000'000};

std::optional<Stamp> at(const Times& times, size_t k) {
  return k < times.size() ? times[k] : std::nullopt;
}

// Start or end of the turns, from their middles: half the usual time before or after.
Times from_middles(const Times& middles, int sign) {
  const Duration half = usual_period(middles) / 2;
  Times times;
  for (const auto& middle : middles) {
    times.push_back(middle ? std::optional(*middle + sign * half) : std::nullopt);
  }
  return times;
}

// Counts one kind of wrong turn, to note it once.
struct WrongTurns {
  std::string file;
  std::string what;
  size_t first = 0;
  size_t count = 0;

  void add(size_t k) {
    if (count++ == 0) first = k;
  }
  void append(std::vector<Error>& notes) const {
    if (count == 0) return;
    notes.push_back({what, file + ":" + std::to_string(first + 1),
                     std::to_string(count) + " such sweeps are skipped"});
  }
};

/// The turns whose stamps agree; notes name the others.
std::vector<std::optional<TurnTimes>> check_turns(const fs::path& folder, const Times& starts,
                                                  const Times& middles, const Times& ends,
                                                  std::vector<Error>& notes) {
  WrongTurns incomplete{folder.string() + "/timestamps*.txt", "not all stamps of a turn are given"};
  WrongTurns reversed{(folder / "timestamps_end.txt").string(),
                      "the end is not within a second after the start"};
  WrongTurns outside{(folder / "timestamps.txt").string(),
                     "the middle is not between start and end"};
  WrongTurns disordered{(folder / "timestamps_start.txt").string(),
                        "the turn starts before the one before it"};
  const size_t count = std::max({starts.size(), middles.size(), ends.size()});
  std::vector<std::optional<TurnTimes>> turns(count);
  Stamp last_start = Stamp::earliest();
  for (size_t k = 0; k < count; ++k) {
    const auto start = at(starts, k), end = at(ends, k);
    auto middle = at(middles, k);
    if (!start && !end && !middle) continue;  // a missing sweep
    if (start && end && middles.empty()) middle = *start + (*end - *start) / 2;
    if (!start || !end || !middle) {
      incomplete.add(k);
    } else if (*end <= *start || *end - *start > kMaxTurn) {
      reversed.add(k);
    } else if (*middle < *start || *middle > *end) {
      outside.add(k);
    } else if (*start <= last_start) {
      disordered.add(k);
    } else {
      turns[k] = {*start, *middle, *end};
      last_start = *start;
    }
  }
  for (const WrongTurns* wrong : {&incomplete, &reversed, &outside, &disordered}) {
    wrong->append(notes);
  }
  return turns;
}

}  // namespace

Result<std::vector<std::optional<TurnTimes>>> read_kitti_turn_times(const fs::path& folder,
                                                                    std::vector<Error>& notes) {
  const fs::path start_file = folder / "timestamps_start.txt";
  const fs::path middle_file = folder / "timestamps.txt";
  const fs::path end_file = folder / "timestamps_end.txt";
  const bool has_turns = fs::exists(start_file) && fs::exists(end_file);
  if (!has_turns && !fs::exists(middle_file)) {
    return fail("has no stamps of the sweeps", folder.string(),
                "expected timestamps_start.txt, timestamps.txt and timestamps_end.txt");
  }
  Times starts, middles, ends;
  const auto read = [](const fs::path& path, Times& times) -> Result<void> {
    return read_kitti_times(path).map([&](Times&& all) { times = std::move(all); });
  };
  if (fs::exists(middle_file)) {
    if (auto done = read(middle_file, middles); !done) return tl::unexpected(done.error());
  }
  if (has_turns) {
    if (auto done = read(start_file, starts); !done) return tl::unexpected(done.error());
    if (auto done = read(end_file, ends); !done) return tl::unexpected(done.error());
  } else {
    starts = from_middles(middles, -1);
    ends = from_middles(middles, 1);
    notes.push_back({"timestamps_start.txt or timestamps_end.txt is missing", folder.string(),
                     "each turn is taken as centred on its stamp in timestamps.txt"});
  }

  if (middles.empty()) {
    notes.push_back({"timestamps.txt is missing", folder.string(),
                     "the middle of a turn is taken as half way from its start to its end"});
  }
  return check_turns(folder, starts, middles, ends, notes);
}

}  // namespace infuse::importers
