#include "tests/study/months/simulated_run.hpp"
#include "daemon/setup/live_setup.hpp"

#include <spdlog/spdlog.h>

#include <cstdlib>
#include <stdexcept>

namespace infuse::study {
namespace {

template <class Value>
Value or_throw(Result<Value> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return *std::move(result);
}

}  // namespace

// As run_live.
SimulatedRun::SimulatedRun(const std::filesystem::path& config_file,
                           const std::filesystem::path& state, std::function<Stamp()> now)
    : config_file_(config_file.string()),
      config_(or_throw(daemon::load_config(config_file))),
      setup_(or_throw(daemon::set_up_live(config_))) {
  spdlog::set_level(spdlog::level::from_str(config_.log_level));
  setenv("STATE_DIRECTORY", state.c_str(), 1);
  host_.emplace(config_, state);
  if (const auto opened = host_->open(setup_.rig, config_.socket.path); !opened) {
    throw std::runtime_error(opened.error().error.message());
  }
  ring_.emplace(8, [this] { return make_item(); });
  publisher_.emplace(*ring_, setup_, config_.health, host_->server(), nullptr);
  recordings_.emplace(config_, setup_, now, daemon::RecorderThread::kNone);
  recordings_->set_publisher(*publisher_);
  history_.emplace(state);
  publisher_->add_alert_listener(
      [this](const daemon::AlertReport& alert) { history_->add(alert); });
  publisher_->add_calibration_listener([this](const auto& report) { history_->add(report); });
  publisher_->add_health_listener(
      [this](const daemon::HealthReport& health) { history_->add(health); });
  lifecycle_.emplace(daemon::ServiceParts{.io = host_->io(),
                                          .publisher = *publisher_,
                                          .recordings = *recordings_,
                                          .server = host_->server(),
                                          .stop = [] {},
                                          .now = now},
                     config_file_, config_, host_->calibration_damage());
}

void SimulatedRun::connect(daemon::DaemonHost::CommandHandler on_command) {
  host_->connect(*publisher_, std::move(on_command), [this](const daemon::Request& request) {
    return recordings_->handle_request(request);
  });
}

daemon::ReportItem SimulatedRun::make_item() const {
  daemon::ReportItem item;
  item.counters = daemon::SensorCounters(setup_);
  return item;
}

void SimulatedRun::push(const daemon::ReportItem& item) {
  ring_->slot() = item;
  ring_->publish();
  while (publisher_->drain()) {
  }
}

void SimulatedRun::work() {
  recordings_->work();
  host_->io().poll();
}

void SimulatedRun::finish() {
  recordings_->finish();
  history_->finish();
  lifecycle_->finish();
  host_->finish(std::chrono::milliseconds(0));
  host_->io().poll();
}

}  // namespace infuse::study
