#include "fusion/motion/sample_queue.hpp"

#include <algorithm>

namespace infuse::motion {
namespace {

constexpr size_t kMaxSamples = 512;               // that wait: bounds memory
constexpr Duration kMaxStampJump{2'000'000'000};  // maximum gap between stamps

bool jumps(Stamp from, Stamp to) { return to - from > kMaxStampJump || from - to > kMaxStampJump; }

}  // namespace

SampleQueue::SampleQueue() { entries_.reserve(kMaxSamples); }

SampleQueue::StampCheck SampleQueue::check(Stamp stamp, Stamp now) {
  const Stamp newest = std::max(newest_, now);
  bool stepped = false;
  if ((!entries_.empty() || now != Stamp::earliest()) && jumps(newest, stamp)) {
    // One outlier stamp is an error; two that agree are a pause or a clock step.
    const bool confirmed = jumped_ && !jumps(*jumped_, stamp);
    jumped_ = stamp;
    if (!confirmed) return StampCheck::kIsolated;
    stepped = stamp < newest;
  }
  jumped_.reset();
  if (stepped) return StampCheck::kClockStep;
  return stamp < now ? StampCheck::kLate : StampCheck::kInOrder;
}

bool SampleQueue::full() const { return entries_.size() == kMaxSamples; }

void SampleQueue::insert(Stamp stamp, const Sample& sample) {
  const auto at =
      std::upper_bound(entries_.begin(), entries_.end(), stamp,
                       [](Stamp value, const Entry& entry) { return value < entry.stamp; });
  entries_.insert(at, Entry{stamp, sample});
  if (!std::holds_alternative<PoseMark>(sample)) newest_ = std::max(newest_, stamp);
}

void SampleQueue::clear() {
  entries_.clear();
  newest_ = Stamp::earliest();
}

}  // namespace infuse::motion
