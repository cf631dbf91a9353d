#pragma once

#include <string>
#include <vector>

#include "daemon/health/sensor_health.hpp"
#include "daemon/pipeline/report_item.hpp"
#include "daemon/pipeline/reports_file.hpp"
#include "daemon/protocol/reports.hpp"
#include "daemon/server/server.hpp"
#include "drivers/measurement/slot_ring.hpp"

namespace infuse::daemon {

/// What a drive came to.
struct Totals {
  bool started = false;  ///< false: the drive was empty
  bool ended = false;
  Stamp start, now;                       ///< drive time
  uint64_t alerts = 0;                    ///< findings that were raised
  std::vector<AlertReport> first_alerts;  ///< the first of these
  std::vector<SensorCounters> counters;   ///< by device
  std::vector<Level> levels;              ///< by device, at the last tick
  HostFigures host;
};

/// Turns the items of the fusion thread into messages: judges health, keeps the totals, tells the
/// server and writes the reports file. On the thread of the `io_context`.
class Publisher {
 public:
  /// Registers as a reader of `in`, which outlives this. `file` may be null.
  Publisher(SlotRing<ReportItem>& in, std::vector<Device> devices, const HealthOptions& health,
            Server& server, ReportsFile* file);

  /// Takes what has come, but not for long. True where more waits.
  bool drain();

  const Totals& totals() const { return totals_; }

 private:
  void take(const ReportItem& item);
  void start(Stamp stamp);
  void tell_sweep(const ReportItem& item);
  void tell_health(const ReportItem& item);
  void tell_devices(Stamp stamp);
  void tell_transitions(Stamp stamp, size_t device, const SensorStatus& status);
  void tell(ReportClass report_class, const std::string& device, Stamp stamp, std::string message);
  HostFigures host_figures(const ReportItem& item) const;

  SlotRing<ReportItem>& ring_;
  SlotRing<ReportItem>::Reader in_;
  std::vector<Device> devices_;
  HealthOptions health_options_;
  std::vector<SensorHealth> health_;
  Server& server_;
  ReportsFile* file_;
  Totals totals_;
};

/// Processor time of this process so far, s.
double process_cpu_s();

}  // namespace infuse::daemon
