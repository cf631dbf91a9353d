#include "drivers/import/kitti_exposures.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/text/numbers.hpp"

namespace infuse::importers {
namespace {

constexpr Duration kMaxOffset{1'000'000'000};
constexpr Duration kMaxDelay{50'000'000};
constexpr Duration kMaxScatter{10'000'000};
constexpr Duration kAfterTrigger{3'000'000};  // from the trigger to the middle of the exposure
constexpr Duration kExposureSigma{3'000'000};

// Stamp minus middle of the turn of the same number, in order of size.
std::vector<Duration> sorted_delays(const std::vector<std::optional<TurnTimes>>& turns,
                                    const std::vector<StampedFile>& files) {
  std::vector<Duration> delays;
  for (const StampedFile& file : files) {
    if (file.number >= turns.size() || !turns[file.number]) continue;
    delays.push_back(file.times.stamp - turns[file.number]->middle);
  }
  std::sort(delays.begin(), delays.end());
  return delays;
}

std::string format_ms(Duration duration) {
  const double ms = std::round(to_seconds(duration) * 1e4) / 10;
  std::string text;
  text::append_number(text, ms);
  return text + " ms";
}

}  // namespace

Result<void> check_same_clock(const std::string& what,
                              const std::vector<std::optional<TurnTimes>>& turns,
                              const std::vector<StampedFile>& files) {
  const std::vector<Duration> delays = sorted_delays(turns, files);
  if (delays.empty()) return {};
  const Duration median = delays[delays.size() / 2];
  if (median >= -kMaxOffset && median <= kMaxOffset) return {};
  std::string seconds;
  text::append_number(seconds, std::round(to_seconds(median)));
  return fail("the stamps are " + seconds + " s after those of the sweeps of the same number", what,
              "check the time zone, and that the files belong to one drive");
}

Result<ExposureTimes> find_exposures(const std::string& camera,
                                     const std::vector<std::optional<TurnTimes>>& turns,
                                     std::vector<StampedFile>& images) {
  if (auto same = check_same_clock(camera, turns, images); !same)
    return tl::unexpected(same.error());
  const std::vector<Duration> delays = sorted_delays(turns, images);
  ExposureTimes result;
  if (delays.empty()) {
    result.note = {"no image belongs to a sweep", camera,
                   "the images' stamps are used as they are"};
    return result;
  }
  const Duration low = delays.front(), median = delays[delays.size() / 2], high = delays.back();
  const std::string range = format_ms(low) + " to " + format_ms(high) + " after";
  const Duration middle_half = delays[3 * delays.size() / 4] - delays[delays.size() / 4];
  if (std::max(median, -median) > kMaxDelay || middle_half > kMaxScatter) {
    result.note = {"the images' stamps do not follow the sweeps: " + range + " the middle of one",
                   camera, "they are used as they are; set stamp_delay_ms if they come late"};
    return result;
  }
  for (StampedFile& image : images) {
    if (image.number < turns.size() && turns[image.number])
      image.times.exposure = turns[image.number]->middle + kAfterTrigger;
  }
  result.delay = median - kAfterTrigger;
  result.sigma = kExposureSigma;
  result.note = {"images are taken as exposed " + format_ms(kAfterTrigger) +
                     " after the middle of their sweep, to " + format_ms(result.sigma) +
                     "; their stamps are " + range + " it",
                 camera,
                 {}};
  return result;
}

}  // namespace infuse::importers
