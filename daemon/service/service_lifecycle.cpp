#include "daemon/service/service_lifecycle.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <csignal>

#include "daemon/health/service_alerts.hpp"
#include "daemon/process/crash_note.hpp"
#include "daemon/process/free_space.hpp"
#include "daemon/process/service_manager.hpp"
#include "daemon/protocol/messages.hpp"

namespace infuse::daemon {
namespace {

// Keys of the configuration that a reload applies; see SIGNALS in infused(8).
constexpr std::array kReloadableKeys = {"version", "log_level", "socket", "health", "record"};

std::string status_text(const Publisher& publisher) {
  const HealthChecks& checks = publisher.checks();
  return fmt::format("{} of {} sensors are OK, {} alerts since the start", checks.ok_sensor_count(),
                     checks.sensor_count(), publisher.totals().alerts);
}

}  // namespace

ServiceLifecycle::ServiceLifecycle(ServiceParts parts, const std::string& config_file,
                                   const Config& config,
                                   const std::optional<std::string>& calibration_damage)
    : parts_(std::move(parts)),
      config_file_(config_file),
      config_(config),
      applied_(config),
      calibration_damage_(calibration_damage),
      run_tracker_(RunTracker::from_environment()),
      reload_signal_(parts_.io, SIGHUP) {
  parts_.publisher.set_progress_listener([this] { on_progress(); });
  parts_.publisher.add_alert_listener([this](const AlertReport& alert) { add_recent(alert); });
  if (const auto folder = run_tracker_.folder(); !folder.empty()) {
    parts_.publisher.add_store([this, folder] {
      return StoreStatus{"state", free_space(folder), run_tracker_.problem()};
    });
  }
  for (const auto& map : parts_.maps) {
    parts_.publisher.add_map([watch = map.get()] { return watch->in_use(); });
  }
  wait_for_reload();
}

void ServiceLifecycle::stop() {
  service_manager::notify_stopping();
  parts_.stop();
}

void ServiceLifecycle::finish() {
  reload_signal_.cancel();
  run_tracker_.end_run(parts_.now());
}

// A tick has passed through every thread; this feeds the watchdog.
void ServiceLifecycle::on_progress() {
  parts_.recordings.publish_updates();
  for (const auto& map : parts_.maps) map->poll(MapWatch::Clock::now());
  const std::string status = status_text(parts_.publisher);
  remember_report(status + recent_alerts_);
  if (!std::exchange(ready_, true)) {
    service_manager::notify_ready(status);
    const Stamp now = parts_.now();
    if (auto alert = run_tracker_.begin_run(now)) parts_.publisher.publish_alert(*alert);
    if (calibration_damage_) {
      const Problem problem{*calibration_damage_,
                            "check infuse calibration; the file is kept as *.unreadable"};
      parts_.publisher.publish_alert(
          {now, kDaemonDevice, true, make_finding(kSavedCalibrationsAlert, now, problem)});
    }
    return;
  }
  service_manager::notify_watchdog();
  service_manager::notify_status(status);
  run_tracker_.save_if_due(parts_.now());
}

/// Keeps the last alerts for a crash note.
void ServiceLifecycle::add_recent(const AlertReport& alert) {
  constexpr size_t kMaxBytes = 3000;
  recent_alerts_ = "\n" + message(alert) + recent_alerts_;  // the newest first
  if (recent_alerts_.size() > kMaxBytes) recent_alerts_.resize(kMaxBytes);
}

void ServiceLifecycle::wait_for_reload() {
  reload_signal_.async_wait([this](boost::system::error_code error, int) {
    if (error) return;
    reload_config();
    wait_for_reload();
  });
}

// The pipeline continues; tracks and calibrations are kept.
void ServiceLifecycle::reload_config() {
  service_manager::notify_reloading();
  for (const auto& map : parts_.maps) map->try_again();
  const auto loaded = load_config(config_file_);
  if (!loaded) {
    spdlog::error("reload failed, the running configuration is kept: {}", loaded.error().message());
  } else {
    apply_config(*loaded);
  }
  service_manager::notify_ready(status_text(parts_.publisher));
}

void ServiceLifecycle::apply_config(const Config& loaded) {
  spdlog::set_level(spdlog::level::from_str(loaded.log_level));
  parts_.server.set_limits(loaded.socket);
  parts_.server.set_configuration(loaded.digest, loaded.version);
  parts_.publisher.set_health_options(loaded.health);
  parts_.recordings.apply_settings(loaded.record);
  const auto reloadable = [](const std::string& key) {
    return std::find(kReloadableKeys.begin(), kReloadableKeys.end(), key) != kReloadableKeys.end();
  };
  std::string applied, needs_restart;
  for (const std::string& key : changed_keys(applied_, loaded)) {
    if (reloadable(key)) applied += " " + key;
  }
  for (const std::string& key : changed_keys(config_, loaded)) {
    if (!reloadable(key)) needs_restart += " " + key;
  }
  applied_ = loaded;
  spdlog::info("configuration reloaded; applied:{}", applied.empty() ? " no changes" : applied);
  if (needs_restart.empty()) return;
  spdlog::warn("changes that need a restart:{} (systemctl restart infused)", needs_restart);
}

}  // namespace infuse::daemon
