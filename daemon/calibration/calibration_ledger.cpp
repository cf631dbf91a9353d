#include "daemon/calibration/calibration_ledger.hpp"

#include <algorithm>

#include "drivers/recording/atomic_file.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

using monitoring::CalibrationState;

/// Returns whether the two differ by no more than printing and parsing can cause.
bool nearly_equal(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff() < 1e-9;
}

/// The one with this pose; null if there is none.
KnownCalibration* find_pose(CameraCalibrations& camera, const Eigen::Isometry3d& T) {
  const auto found = std::find_if(
      camera.known.begin(), camera.known.end(),
      [&](const KnownCalibration& known) { return nearly_equal(known.T_camera_lidar, T); });
  return found == camera.known.end() ? nullptr : &*found;
}

/// Adds what an estimate says of a calibration that came of it.
void add_estimate(KnownCalibration& known, const geometry::Matrix6& covariance,
                  CameraCalibrations& camera, const Eigen::Isometry3d& T_estimated_from) {
  if (known.covariance || known.origin != CalibrationOrigin::kEstimated) return;
  known.covariance = covariance;
  const KnownCalibration* from = find_pose(camera, T_estimated_from);
  if (from != nullptr) known.estimated_from = from->number;
}

std::string of_camera(const Request& request) {
  return request.device.empty() ? "" : " of '" + request.device + "'";
}

constexpr const char* kSeeList = "see infuse calibrations";

/// Why a request for another estimate would have no effect; empty: it has one.
std::string obstacle_of(const CalibrationReport& report) {
  if (report.verdict.fault != monitoring::CameraFault::kNone) {
    return report.camera +
           ": the camera has a fault: " + monitoring::describe_fault(report.verdict);
  }
  if (report.state == CalibrationState::kRecalibrating) {
    return report.camera + ": a re-estimation runs";
  }
  return "";
}

}  // namespace

std::optional<SavedCalibrations> CalibrationLedger::read(std::vector<std::string>& lines) {
  std::error_code ignored;
  if (path_.empty() || !std::filesystem::exists(path_, ignored)) return std::nullopt;
  const auto text = text::read_text(path_, kMaxCalibrationsBytes);
  auto read =
      text ? parse_calibrations(*text) : Result<SavedCalibrations>(tl::unexpected(text.error()));
  if (read) return *std::move(read);
  damage_ = path_.string() + ": " + read.error().what + "; using the configured calibrations";
  lines.push_back(*damage_);
  std::filesystem::rename(path_, path_.string() + ".unreadable", ignored);
  return std::nullopt;
}

std::vector<std::string> CalibrationLedger::restore(Rig& rig) {
  std::vector<std::string> lines;
  saved_ = read(lines).value_or(SavedCalibrations{});
  cameras_.clear();
  for (CameraMount& mount : rig.cameras) restore(mount, lines);
  return lines;
}

void CalibrationLedger::restore(CameraMount& mount, std::vector<std::string>& lines) {
  cameras_.push_back(mount.name);
  CameraCalibrations* camera = saved_.find(mount.name);
  const Eigen::Isometry3d configured = mount.T_camera_lidar;
  if (camera == nullptr) {
    saved_.cameras.push_back({.camera = mount.name, .T_camera_lidar_configured = configured});
    camera = &saved_.cameras.back();
    camera->in_use = learn(*camera, configured, {}, CalibrationOrigin::kConfigured).number;
    return;
  }
  if (camera->frozen) lines.push_back(mount.name + ": calibration frozen");
  if (!nearly_equal(camera->T_camera_lidar_configured, configured)) {
    lines.push_back(mount.name + ": using the configured calibration, which has changed");
    camera->T_camera_lidar_configured = configured;
    const uint64_t number = learn(*camera, configured, {}, CalibrationOrigin::kConfigured).number;
    if (number != camera->in_use) camera->previous = std::exchange(camera->in_use, number);
    unsaved_ = true;
    return;
  }
  mount.T_camera_lidar = camera->find(camera->in_use)->T_camera_lidar;
  if (nearly_equal(mount.T_camera_lidar, configured)) return;
  lines.push_back(mount.name + ": using the saved calibration " + std::to_string(camera->in_use));
}

std::vector<CalibrationCommand> CalibrationLedger::restore_commands() const {
  std::vector<CalibrationCommand> commands;
  for (const CameraCalibrations& camera : saved_.cameras) {
    const bool mounted =
        std::find(cameras_.begin(), cameras_.end(), camera.camera) != cameras_.end();
    if (!mounted || !camera.frozen) continue;
    commands.push_back({.kind = CalibrationCommand::Kind::kFreeze, .camera = camera.camera});
  }
  return commands;
}

std::vector<std::string> CalibrationLedger::cameras_of(const Request& request) const {
  return request.device.empty() ? cameras_ : std::vector{request.device};
}

Result<OwnerDecision> CalibrationLedger::decide(const Request& request) {
  if (cameras_.empty()) return fail("no camera is configured");
  std::string names;
  for (const std::string& camera : cameras_) names += " " + camera;
  for (const std::string& camera : cameras_of(request)) {
    if (std::find(cameras_.begin(), cameras_.end(), camera) == cameras_.end()) {
      return fail("unknown camera '" + camera + "'", "", "known:" + names);
    }
  }
  if (request.op == Request::Op::kRecalibrate) return recalibrate(request);
  const SavedCalibrations before = saved_;
  const std::map<std::string, uint64_t> decisions_before = decisions_;
  auto decision = request.op == Request::Op::kApply      ? apply(request)
                  : request.op == Request::Op::kRollback ? roll_back(request)
                                                         : freeze(request);
  if (!decision) return decision;
  if (auto written = write(); !written) {
    saved_ = before;
    decisions_ = decisions_before;
    return tl::unexpected(written.error());
  }
  if (path_.empty()) decision->note = "not kept over a restart: there is no state directory";
  return decision;
}

void CalibrationLedger::put_into_use(CameraCalibrations& camera, uint64_t number, bool rolls_back,
                                     OwnerDecision& decision) {
  const KnownCalibration& known = *camera.find(number);
  camera.previous = std::exchange(camera.in_use, number);
  camera.proposed.reset();
  decisions_[camera.camera] = next_decision_++;
  decision.commands.push_back({.camera = camera.camera,
                               .calibration = {known.T_camera_lidar, known.covariance, rolls_back},
                               .decision = decisions_[camera.camera]});
}

Result<OwnerDecision> CalibrationLedger::apply(const Request& request) {
  OwnerDecision decision;
  for (const std::string& name : cameras_of(request)) {
    CameraCalibrations& camera = *saved_.find(name);
    std::optional<uint64_t> number = camera.proposed;
    if (request.T_camera_lidar) {
      number = learn(camera, *request.T_camera_lidar, last_[name].stamp, CalibrationOrigin::kGiven)
                   .number;
    } else if (request.number) {
      number = camera.find(*request.number) != nullptr ? request.number : std::nullopt;
    }
    if (!number) continue;
    if (*number == camera.in_use) {
      return fail("calibration " + std::to_string(*number) + " of '" + name + "' is in use", "",
                  kSeeList);
    }
    put_into_use(camera, *number, false, decision);
  }
  if (!decision.commands.empty()) return decision;
  if (request.number) {
    return fail("no calibration" + of_camera(request) + " has the number " +
                    std::to_string(*request.number),
                "", kSeeList);
  }
  return fail("no new calibration" + of_camera(request) + " waits to be applied", "",
              "infuse recalibrate requests one; infuse calibrations lists earlier ones, which "
              "infuse apply NUMBER puts into use");
}

Result<OwnerDecision> CalibrationLedger::roll_back(const Request& request) {
  OwnerDecision decision;
  for (const std::string& name : cameras_of(request)) {
    CameraCalibrations& camera = *saved_.find(name);
    if (camera.previous) put_into_use(camera, *camera.previous, true, decision);
  }
  if (!decision.commands.empty()) return decision;
  return fail("there is no calibration" + of_camera(request) + " before the one in use", "",
              kSeeList);
}

Result<OwnerDecision> CalibrationLedger::recalibrate(const Request& request) {
  OwnerDecision decision;
  std::string obstacles;
  for (const std::string& name : cameras_of(request)) {
    const CalibrationReport& report = last_[name];
    if (const std::string obstacle = obstacle_of(report); !obstacle.empty()) {
      obstacles += (obstacles.empty() ? "" : "; ") + obstacle;
      continue;
    }
    decision.commands.push_back({.kind = CalibrationCommand::Kind::kRecalibrate, .camera = name});
    decision.note += (decision.note.empty() ? "" : "; ") + name + ": ";
    decision.note += report.camera.empty()
                         ? "waits for images"
                         : "begins when " + std::to_string(report.needed_scenes) +
                               " scenes are stored, " + std::to_string(report.scenes) + " now";
  }
  if (decision.commands.empty()) return fail(obstacles, "", "see infuse calibration");
  return decision;
}

Result<OwnerDecision> CalibrationLedger::freeze(const Request& request) {
  OwnerDecision decision;
  for (const std::string& name : cameras_of(request)) {
    saved_.find(name)->frozen = request.on;
    decision.commands.push_back(
        {.kind = CalibrationCommand::Kind::kFreeze, .camera = name, .frozen = request.on});
  }
  return decision;
}

/// The calibration of a camera with this pose, new if there was none.
KnownCalibration& CalibrationLedger::learn(CameraCalibrations& camera, const Eigen::Isometry3d& T,
                                           Stamp stamp, CalibrationOrigin origin) {
  if (KnownCalibration* known = find_pose(camera, T)) return *known;
  unsaved_ = true;
  if (camera.known.size() >= kMaxKept) forget_oldest(camera);
  camera.known.push_back(
      {.number = saved_.next_number++, .stamp = stamp, .origin = origin, .T_camera_lidar = T});
  return camera.known.back();
}

void CalibrationLedger::forget_oldest(CameraCalibrations& camera) {
  const auto oldest =
      std::find_if(camera.known.begin(), camera.known.end(), [&](const KnownCalibration& known) {
        return known.number != camera.in_use && known.number != camera.previous &&
               known.number != camera.proposed;
      });
  camera.known.erase(oldest);
}

Result<void> CalibrationLedger::observe(CalibrationReport& report) {
  CameraCalibrations* camera = saved_.find(report.camera);
  if (camera == nullptr) return {};
  if (report.decision >= decisions_[report.camera]) follow(*camera, report);
  describe(*camera, report);
  last_[report.camera] = report;
  return unsaved_ ? write() : Result<void>();
}

/// Numbers what a guard uses and proposes.
void CalibrationLedger::follow(CameraCalibrations& camera, const CalibrationReport& report) {
  const uint64_t in_use =
      learn(camera, report.T_camera_lidar, report.stamp, CalibrationOrigin::kEstimated).number;
  if (in_use != camera.in_use) {
    camera.previous = std::exchange(camera.in_use, in_use);
    unsaved_ = true;
  }
  if (report.estimate && nearly_equal(report.estimate->T_camera_lidar, report.T_camera_lidar)) {
    add_estimate(*find_pose(camera, report.T_camera_lidar), report.estimate->covariance, camera,
                 report.estimate->T_estimated_from);
  }
  camera.proposed.reset();
  if (!report.proposal) return;
  const CalibrationEstimate& proposal = *report.proposal;
  camera.proposed =
      learn(camera, proposal.T_camera_lidar, report.stamp, CalibrationOrigin::kEstimated).number;
  add_estimate(*find_pose(camera, proposal.T_camera_lidar), proposal.covariance, camera,
               proposal.T_estimated_from);
}

/// Says which calibrations are known, and what of them is done.
void CalibrationLedger::describe(const CameraCalibrations& camera, CalibrationReport& report) {
  report.known = camera.known;
  for (KnownCalibration& known : report.known) {
    known.use = known.number == camera.in_use     ? CalibrationUse::kInUse
                : known.number == camera.proposed ? CalibrationUse::kProposed
                : known.number == camera.previous ? CalibrationUse::kPrevious
                                                  : CalibrationUse::kEarlier;
    if (known.use == CalibrationUse::kEarlier) known.covariance.reset();  // short reports
  }
}

Result<void> CalibrationLedger::write() {
  unsaved_ = !path_.empty();
  if (path_.empty()) return {};
  std::error_code ignored;  // write_file_atomically reports the error
  std::filesystem::create_directories(path_.parent_path(), ignored);
  const std::string text = format_calibrations(saved_);
  auto written = recording::write_file_atomically(path_, std::as_bytes(std::span(text)), 0640);
  unsaved_ = !written;
  return written;
}

}  // namespace infuse::daemon
