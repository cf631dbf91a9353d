#include "tests/study/months/simulation.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>

#include "daemon/calibration/saved_calibrations.hpp"
#include "daemon/history/history_file.hpp"

namespace infuse::study {
namespace {

namespace fs = std::filesystem;
using daemon::Request;

constexpr int64_t kStart = 1'780'000'000;  // s since the epoch, in 2026
constexpr uint32_t kTopAddress = 0x0A00'0007, kRearAddress = 0x0A00'0008;
constexpr uint64_t kBudget = 2 << 20;         // bytes, of recordings
constexpr uint64_t kLastRecording = 1 << 20;  // bytes; more than a recording takes

/// On a file system in memory if there is one: the daemon syncs its files.
fs::path make_folder() {
  const fs::path memory = "/dev/shm";
  std::string name =
      (::access(memory.c_str(), W_OK) == 0 ? memory : fs::temp_directory_path()) / "infuse-XXXXXX";
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  return name;
}

void write_text(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << text;
}

std::string read_text(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(in), {});
}

void replace_in(const fs::path& file, const std::string& what, const std::string& by) {
  std::string text = read_text(file);
  const size_t at = text.find(what);
  if (at != std::string::npos) write_text(file, text.replace(at, what.size(), by));
}

/// T_camera_lidar of the rig; `x`: its position.
std::string rig_text(double x) {
  return "[[lidar]]\nname = \"top\"\n"
         "T_vehicle_lidar = [1,0,0,1.5, 0,1,0,0, 0,0,1,1.8, 0,0,0,1]\n"
         "[[lidar]]\nname = \"rear\"\n"
         "T_vehicle_lidar = [-1,0,0,-0.5, 0,-1,0,0, 0,0,1,1.2, 0,0,0,1]\n"
         "[[camera]]\nname = \"front\"\nlidar = \"top\"\nwidth = 640\nheight = 480\nfx = 500\n"
         "fy = 500\ncx = 320\ncy = 240\nT_camera_lidar = [0,-1,0," +
         std::to_string(x) + ", 0,0,-1,0, 1,0,0,0, 0,0,0,1]\n";
}

constexpr const char* kSensors = R"(
[[lidar]]
name = "top"
model = "VLP-16"
port = 2368
[[camera]]
name = "front"
device = "/dev/video0"
[[can]]
name = "bus"
interface = "can0"
dbc = "car.dbc"
[can.signals]
wheel_speed_rear_left = "ESP.LEFT"
wheel_speed_rear_right = "ESP.RIGHT"
yaw_rate = "ESP.YAW"
[gnss]
device = "/dev/ttyUSB0"
)";

constexpr const char* kRearLidar =
    "[[lidar]]\nname = \"rear\"\nmodel = \"VLP-16\"\nport = 2369\nsender = \"10.0.0.8\"\n";

constexpr const char* kDbc =
    "BO_ 291 ESP: 8 X\n SG_ LEFT : 0|16@1- (0.01,0) [0|0] \"m/s\" X\n"
    " SG_ RIGHT : 16|16@1- (0.01,0) [0|0] \"m/s\" X\n"
    " SG_ YAW : 32|16@1- (0.01,0) [0|0] \"deg/s\" X\n";

/// The file of the calibrations as the release before wrote it.
std::string in_form_1(const std::string& text) {
  const auto saved = daemon::parse_calibrations(text);
  nlohmann::json json = {{"form", 1}, {"cameras", nlohmann::json::array()}};
  if (!saved) return json.dump();
  const auto numbers = [](const Eigen::Isometry3d& T) {
    const Eigen::Matrix4d by_column = T.matrix().transpose();
    return std::vector<double>(by_column.data(), by_column.data() + 16);
  };
  for (const daemon::CameraCalibrations& camera : saved->cameras) {
    const daemon::KnownCalibration& used = *camera.find(camera.in_use);
    json["cameras"].push_back(
        {{"camera", camera.camera},
         {"since_ns", used.stamp.ns()},
         {"T_camera_lidar_configured", numbers(camera.T_camera_lidar_configured)},
         {"T_camera_lidar", numbers(used.T_camera_lidar)}});
  }
  return json.dump();
}

Eigen::Isometry3d configured_pose() {
  Eigen::Matrix4d matrix;
  matrix << 0, -1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0, 0, 0, 0, 1;
  return Eigen::Isometry3d(matrix);
}

/// True for alerts that only who raised them knows about.
bool is_service_alert(const std::string& id) {
  return id.starts_with("infused.") && id != "infused.missing_sensors" &&
         id != "infused.no_sensors" && id != "infused.state";
}

}  // namespace

Simulation::Simulation(const SimulationOptions& options, std::vector<Fault> faults)
    : options_(options),
      folder_(make_folder()),
      faults_(std::move(faults)),
      top_("top", kTopAddress, 0, options.seed * 10 + 1),
      rear_("rear", kRearAddress, kRearAddress, options.seed * 10 + 2),
      front_("front", 10),
      bus_("bus", 50),
      gnss_("gnss", 5),
      vehicle_(options.seed * 10 + 3),
      camera_("front", configured_pose(), options.seed * 10 + 4) {
  std::signal(SIGXFSZ, SIG_IGN);
  host_.truth = Stamp::from_ns(kStart * 1'000'000'000);
  host_.booted = host_.truth - from_seconds(100);
  fs::create_directories(state());
  write_config();
  start_run();
}

Simulation::~Simulation() {
  run_.reset();
  unsetenv("STATE_DIRECTORY");
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

void Simulation::write_config() const {
  fs::create_directories(folder_ / "infused.toml.d");
  write_text(folder_ / "rig.toml", rig_text(0));
  write_text(folder_ / "car.dbc", kDbc);
  write_text(folder_ / "infused.toml",
             "log_level = \"off\"\nrig = \"rig.toml\"\n[socket]\npath = \"" +
                 (folder_ / "socket").string() +
                 "\"\n[health]\nexpected_sensors = [\"top\", \"rear\", \"front\", \"bus\", "
                 "\"gnss\"]\n[calibration]\npolicy = \"" +
                 options_.policy +
                 "\"\n[record]\nmemory_mb = 16\nflight_recorder_s = 10\nafter_alert_s = 5\n"
                 "min_free_mb = 0\nbudget_mb = 2\nkeep_alerts = 100\n");
  write_text(folder_ / "infused.toml.d" / "1-sensors.toml", kSensors);
  write_text(folder_ / "infused.toml.d" / "2-rear.toml", kRearLidar);
}

Stamp Simulation::now() const { return base_.at_monotonic(host_.read(host_.truth).monotonic_ns); }

void Simulation::start_run() {
  base_ = host::TimeBase(host_.read(host_.truth));
  raised_.clear();
  run_ =
      std::make_unique<SimulatedRun>(folder_ / "infused.toml", state(), [this] { return now(); });
  watch_run();
  top_.restart(base_);
  rear_.restart(base_);
  front_.restart();
  bus_.restart();
  gnss_.restart();
  vehicle_.restart(run_->config().odometry);
  const auto& cameras = run_->setup().rig.cameras;
  camera_.restart(cameras.empty() ? configured_pose() : cameras[0].T_camera_lidar,
                  run_->config().calibration);
  run_->connect(
      [this](const daemon::CalibrationCommand& command) { camera_.handle(command, now()); });
  not_deskewed_ = 0;
  daemon::ReportItem item = run_->make_item();
  item.stamp = now();
  run_->push(item);
  run_->work();
}

void Simulation::watch_run() {
  run_->publisher().add_alert_listener(
      [this](const daemon::AlertReport& alert) { observe(alert); });
  run_->publisher().add_health_listener(
      [this](const daemon::HealthReport& health) { check(health); });
}

void Simulation::observe(const daemon::AlertReport& alert) {
  const std::string id = alert.id();
  alerts_.push_back({second_, id, alert.raised, alert.finding.level});
  const bool changed = alert.raised ? raised_.insert(id).second : raised_.erase(id) == 1;
  if (!changed) problem(id + (alert.raised ? " is raised twice" : " is cleared, but not raised"));
  if (alert.finding.what.empty() || alert.finding.advice.empty()) problem(id + " says nothing");
}

// HEALTH and the alerts must say the same.
void Simulation::check(const daemon::HealthReport& health) {
  std::set<std::string> found;
  const auto add = [&](const std::string& device, const std::vector<daemon::Finding>& findings) {
    for (const daemon::Finding& finding : findings) found.insert(device + "." + finding.id);
  };
  for (const auto& sensor : health.sensors) add(sensor.device, sensor.status.findings);
  for (const auto& stream : health.streams) add(stream.device, stream.status.findings);
  if (health.odometry) add("odometry", health.odometry->findings);
  for (const auto& calibration : health.calibrations) add(calibration.camera, calibration.findings);
  add(daemon::kDaemonDevice, health.findings);
  std::set<std::string> alerted;
  for (const std::string& id : raised_) {
    if (!is_service_alert(id)) alerted.insert(id);
  }
  if (found != alerted) problem("HEALTH and the alerts differ");
  level_ = health.level();
}

void Simulation::problem(const std::string& what) {
  constexpr size_t kMaxProblems = 20;
  if (problems_.size() < kMaxProblems) {
    problems_.push_back(std::to_string(second_) + ": " + what);
  }
}

void Simulation::step() {
  ++second_;
  host_.truth += from_seconds(1);
  faults_.advance(second_);
  if (clock_right_at_ && second_ >= *clock_right_at_) {
    host_.step(-host_.wall_error);
    clock_right_at_.reset();
  }
  set_disk();
  apply_events();
  if (!run_ && second_ >= start_at_) start_run();
  if (run_) tick();
  if (second_ % 10 == 0) measure_disk();
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_FSIZE, &limit);
}

/// A full disk creates files, but lets none grow; a missing one has a file in its place.
void Simulation::set_disk() {
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  limit.rlim_cur = faults_.has("disk", "full") ? 0 : limit.rlim_max;
  const bool missing = faults_.has("disk", "missing");
  if (missing && !missing_) {
    fs::rename(state(), folder_ / "away");
    write_text(state(), "");
  } else if (!missing && missing_) {
    fs::remove(state());
    fs::rename(folder_ / "away", state());
  }
  missing_ = missing;
  setrlimit(RLIMIT_FSIZE, &limit);
}

void Simulation::apply_events() {
  for (const Fault& fault : faults_.begun()) {
    if (fault.subject == "service") {
      apply_service_event(fault);
    } else if (fault.subject == "host") {
      apply_host_event(fault);
    } else if (fault.subject == "owner") {
      apply_owner_event(fault);
    } else {
      apply_file_event(fault);
    }
  }
}

void Simulation::end_run(bool clean, int64_t down_for) {
  if (clean && run_) run_->finish();
  run_.reset();
  start_at_ = second_ + down_for;
}

void Simulation::apply_service_event(const Fault& fault) {
  end_run(fault.kind == "restart", 1);
  if (fault.kind == "watchdog") write_text(state() / "abort_marker", "");
}

void Simulation::apply_host_event(const Fault& fault) {
  if (fault.kind == "step") return host_.step(from_seconds(fault.value));
  const bool clockless = fault.kind == "clockless";
  end_run(fault.kind != "power_cut", clockless ? 30 : static_cast<int64_t>(fault.value));
  host_.booted = host_.truth + from_seconds(static_cast<double>(start_at_ - second_) - 20);
  host_.stepped_at = Stamp::earliest();
  if (!clockless) return;
  // No battery: the clock begins at the epoch.
  host_.wall_error = host_.wall_error_before = Duration(-host_.booted.ns());
  clock_right_at_ = start_at_ + static_cast<int64_t>(fault.value);
}

void Simulation::apply_file_event(const Fault& fault) {
  const fs::path calibrations = state() / daemon::kCalibrationsFile, runs = state() / "state.json";
  const std::string what = fault.subject + " " + fault.kind;
  if (what == "calibrations damaged") write_text(calibrations, "{\"form\": 1, \"cameras\": [{");
  if (what == "calibrations newer") write_text(calibrations, "{\"form\": 3, \"cameras\": {}}");
  if (what == "calibrations older") write_text(calibrations, in_form_1(read_text(calibrations)));
  if (what == "state damaged") write_text(runs, "\0\0\0\0");
  if (what == "state newer") replace_in(runs, "\"form\": 1", "\"form\": 2");
  if (what == "history damaged") {
    std::ofstream(state() / daemon::kHistoryFile, std::ios::app) << "{\"form\":1,\"cla";
  }
  if (what == "config rig") write_text(folder_ / "rig.toml", rig_text(0.25));
  if (what == "config dropin") fs::remove(folder_ / "infused.toml.d" / "2-rear.toml");
  if (what == "config empty") fs::remove_all(folder_ / "infused.toml.d");
}

void Simulation::apply_owner_event(const Fault& fault) {
  if (!run_) return;
  Request request;
  if (fault.kind == "apply") request.op = Request::Op::kApply;
  if (fault.kind == "rollback") request.op = Request::Op::kRollback;
  if (fault.kind == "recalibrate") request.op = Request::Op::kRecalibrate;
  if (fault.kind == "freeze" || fault.kind == "unfreeze") request.op = Request::Op::kFreeze;
  if (fault.kind == "record" || fault.kind == "stop") request.op = Request::Op::kRecord;
  request.on = fault.kind != "unfreeze" && fault.kind != "stop";
  if (fault.kind == "record") request.max_duration = from_seconds(fault.value);
  if (run_->handle_request(request)) return;
  alerts_.push_back({second_, "owner." + fault.kind + "_refused", true, daemon::Level::kOk});
}

void Simulation::tick() {
  top_.deliver(host_, faults_);
  rear_.deliver(host_, faults_);
  front_.deliver(now(), faults_);
  bus_.deliver(now(), faults_);
  gnss_.deliver(now(), faults_);
  vehicle_.drive(now(), bus_.delivers(), gnss_.delivers(), faults_);
  const bool rear = run_->setup().lidars.size() > 1;
  record_data();
  if (const auto report = camera_.observe(now(), top_.delivers() && front_.delivers(), faults_);
      report && !run_->setup().rig.cameras.empty()) {
    daemon::ReportItem item = run_->make_item();
    item.kind = daemon::ReportItem::Kind::kCalibration;
    item.stamp = now();
    item.calibration = *report;
    run_->push(item);
  }
  daemon::ReportItem item = run_->make_item();
  item.kind = daemon::ReportItem::Kind::kTick;
  item.stamp = now();
  if (!item.counters.lidars.empty()) {
    item.counters.lidars[0] = top_.counters();
    if (rear) item.counters.lidars[1] = rear_.counters();
    item.counters.cameras.at(0) = front_.counters();
    item.counters.buses.at(0) = bus_.counters();
    item.counters.gnss = gnss_.counters();
    item.odometry = vehicle_.status(now());
    if (!item.odometry.usable()) not_deskewed_ += top_.delivers() ? 10 : 0;
    item.odometry.not_deskewed = not_deskewed_;
  }
  run_->push(item);
  run_->work();
}

/// What the io thread would hand to the recorder, thinned.
void Simulation::record_data() {
  daemon::RecordTap* tap = run_->tap();
  if (tap == nullptr) return;
  const std::vector<uint8_t> payload(1206);
  for (int i = 0; top_.delivers() && i < 20; ++i) {
    tap->add_datagram({now() - from_seconds(1 - i / 20.0), kTopAddress, 2368, 2368, payload});
  }
  GnssFix fix{.stamp = now(), .valid = true};
  if (gnss_.delivers()) tap->add_gnss(fix);
  tap->flush_if_due(now() - from_seconds(0.3));
  tap->flush_if_due(now());
}

uint64_t Simulation::bytes_in(const fs::path& folder) {
  uint64_t bytes = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code none;
    if (entry->is_regular_file(none)) bytes += entry->file_size(none);
  }
  return bytes;
}

void Simulation::measure_disk() {
  if (missing_) return;
  const uint64_t bytes = bytes_in(state() / "drives");
  max_recorded_bytes_ = std::max(max_recorded_bytes_, bytes);
  if (bytes > kBudget + kLastRecording) problem("the recordings exceed their budget");
  std::error_code error;
  for (fs::directory_iterator entry(state() / "drives", error), end; !error && entry != end;
       entry.increment(error)) {
    recordings_.insert(entry->path().filename().string());
  }
}

void Simulation::finish() { end_run(true, 0); }

}  // namespace infuse::study
