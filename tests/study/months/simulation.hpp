#pragma once

#include <memory>
#include <set>

#include "tests/study/months/fault.hpp"
#include "tests/study/months/simulated_camera.hpp"
#include "tests/study/months/simulated_lidar.hpp"
#include "tests/study/months/simulated_run.hpp"
#include "tests/study/months/simulated_stream.hpp"
#include "tests/study/months/simulated_vehicle.hpp"

namespace infuse::study {

/// An alert that a client of the daemon would have seen.
struct ObservedAlert {
  int64_t second = 0;
  std::string id;
  bool raised = false;
  daemon::Level level = daemon::Level::kOk;
};

/// Settings of a simulation.
struct SimulationOptions {
  uint64_t seed = 1;
  std::string policy = "alert-only";  ///< of [calibration]
};

/// A vehicle with two lidars, a camera, a bus, a GNSS receiver and the daemon on its computer, in
/// steps of a second and without waiting: faults in, alerts, states and files out. The daemon's
/// parts are the product's; only the streams of the sensors are replaced by their counters and by
/// samples.
///
/// Faults beside those of the sensors: service restart, crash, watchdog; host reboot S, power_cut
/// S, step S (of the wall clock), clockless S (a reboot; the wall clock is right after S);
/// disk full, missing; calibrations damaged, newer, older; state damaged, newer; history damaged;
/// config rig, dropin, empty; owner apply, rollback, freeze, unfreeze, recalibrate, record, stop.
class Simulation {
 public:
  Simulation(const SimulationOptions& options, std::vector<Fault> faults);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// Simulates the next second.
  void step();
  void run_until(int64_t second) {
    while (second_ < second) step();
  }
  /// Ends the daemon as at SIGTERM.
  void finish();

  int64_t second() const { return second_; }
  const std::vector<ObservedAlert>& alerts() const { return alerts_; }
  /// What must never be: alerts that contradict HEALTH, raised twice, more on the disk than
  /// allowed.
  const std::vector<std::string>& problems() const { return problems_; }
  const SimulatedCamera& camera() const { return camera_; }
  /// Number of drives that were recorded.
  size_t recordings() const { return recordings_.size(); }
  uint64_t max_recorded_bytes() const { return max_recorded_bytes_; }
  /// Files of the daemon's state.
  std::filesystem::path state() const { return folder_ / "state"; }
  /// The last daemon level of HEALTH.
  daemon::Level level() const { return level_; }
  /// Bytes below a folder.
  static uint64_t bytes_in(const std::filesystem::path& folder);

 private:
  void write_config() const;
  void start_run();
  void watch_run();
  void apply_events();
  void apply_service_event(const Fault& fault);
  void apply_host_event(const Fault& fault);
  void apply_file_event(const Fault& fault);
  void apply_owner_event(const Fault& fault);
  void set_disk();
  void tick();
  void record_data();
  void end_run(bool clean, int64_t down_for);
  void check(const daemon::HealthReport& health);
  void observe(const daemon::AlertReport& alert);
  void measure_disk();
  void problem(const std::string& what);
  Stamp now() const;

  SimulationOptions options_;
  std::filesystem::path folder_;
  FaultSchedule faults_;
  SimulatedHost host_;
  host::TimeBase base_;
  SimulatedLidar top_, rear_;
  SimulatedStream front_, bus_, gnss_;
  SimulatedVehicle vehicle_;
  SimulatedCamera camera_;
  std::unique_ptr<SimulatedRun> run_;
  int64_t second_ = 0, start_at_ = 0;
  std::optional<int64_t> clock_right_at_;
  uint64_t not_deskewed_ = 0;
  bool missing_ = false;  // the state directory
  std::vector<ObservedAlert> alerts_;
  std::set<std::string> raised_;  // in this run
  std::vector<std::string> problems_;
  std::set<std::string> recordings_;
  uint64_t max_recorded_bytes_ = 0;
  daemon::Level level_ = daemon::Level::kOk;
};

}  // namespace infuse::study
