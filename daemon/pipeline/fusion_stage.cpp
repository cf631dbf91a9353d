#include "daemon/pipeline/fusion_stage.hpp"

#include "daemon/pipeline/sweep_summary.hpp"

namespace infuse::daemon {

FusionStage::FusionStage(SlotRing<StreamItem>& in, SlotRing<ReportItem>& out, Doorbell& bell)
    : stream_(in), in_(in.reader()), out_(out), bell_(bell) {}

void FusionStage::run() {
  bool ended = false;
  while (!ended && in_.wait()) {
    const Pin<StreamItem> item = in_.next();
    if (!item) continue;
    take(*item);
    ended = item->kind == StreamItem::Kind::kEnd;
  }
}

void FusionStage::take(const StreamItem& item) {
  ReportItem& report = out_.hand();
  report.kind = item.kind;
  report.stamp = item.stamp;
  if (item.kind == StreamItem::Kind::kSweep) take_sweep(item, report);
  if (item.kind == StreamItem::Kind::kTick) take_tick(item, report);
  out_.wait_for_room();
  out_.publish();
  bell_.ring();
}

void FusionStage::take_sweep(const StreamItem& item, ReportItem& report) {
  const HostClock::time_point begin = HostClock::now();
  report.sweep = summarise(item.sweep, item.device);
  const HostClock::time_point end = HostClock::now();
  latency_.add(end - begin);
  whole_latency_.add(end - item.taken);
  if (end - item.taken > kBudget) ++deadline_misses_;
}

void FusionStage::take_tick(const StreamItem& item, ReportItem& report) {
  report.counters = item.counters;  // of equal length: no allocation
  report.intake = item.intake;
  report.fusion = latency_.figures();
  report.whole = whole_latency_.figures();
  report.deadline_misses = deadline_misses_;
  report.sweeps_waiting = {"sweeps", static_cast<uint32_t>(in_.behind()),
                           static_cast<uint32_t>(stream_.capacity())};
}

}  // namespace infuse::daemon
