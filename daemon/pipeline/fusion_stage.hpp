#pragma once

#include <cstdint>

#include "daemon/health/latency_histogram.hpp"
#include "daemon/pipeline/doorbell.hpp"
#include "daemon/pipeline/report_item.hpp"
#include "daemon/pipeline/stream_item.hpp"
#include "drivers/measurement/slot_ring.hpp"

namespace infuse::daemon {

/// The fusion thread: takes sweeps and ticks in order and makes reports of them. In a replay it
/// waits for whoever tells the reports, and drops none.
class FusionStage {
 public:
  /// From the reading of the packet that completed a sweep to its report, at most, host time.
  static constexpr Duration kBudget{100'000'000};

  /// Registers as a reader of `in`. The rings and the bell outlive this.
  FusionStage(SlotRing<StreamItem>& in, SlotRing<ReportItem>& out, Doorbell& bell);

  /// Until the item kEnd has been passed on.
  void run();

 private:
  void take(const StreamItem& item);
  void take_sweep(const StreamItem& item, ReportItem& report);
  void take_tick(const StreamItem& item, ReportItem& report);

  SlotRing<StreamItem>& stream_;
  SlotRing<StreamItem>::Reader in_;
  SlotRing<ReportItem>& out_;
  Doorbell& bell_;
  LatencyHistogram latency_;
  LatencyHistogram whole_latency_;
  uint64_t deadline_misses_ = 0;
};

}  // namespace infuse::daemon
