#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/calibration/calibration_command.hpp"
#include "daemon/calibration/saved_calibrations.hpp"
#include "daemon/protocol/request.hpp"
#include "drivers/measurement/rig.hpp"

namespace infuse::daemon {

/// What a request of the owner leads to.
struct OwnerDecision {
  std::vector<CalibrationCommand> commands;  ///< for the guards
  std::string note;                          ///< for the owner; empty: nothing to say
};

/// The calibrations of all cameras that were in use or proposed, by numbers that they keep, and
/// what the owner decides about them. Kept over restarts in a file that survives a power cut: what
/// a decision says is in the file before it is returned. Single-threaded.
class CalibrationLedger {
 public:
  /// Calibrations of a camera that are kept; the oldest without a use goes first.
  static constexpr size_t kMaxKept = 32;

  /// `path` empty: nothing is saved.
  explicit CalibrationLedger(std::filesystem::path path) : path_(std::move(path)) {}

  /// Reads the file and sets the saved calibrations in the rig, camera by camera. A configured
  /// calibration that has changed since takes precedence. A file that cannot be read, damaged or of
  /// another release, is kept beside it with the suffix .unreadable. Returns lines for the log.
  std::vector<std::string> restore(Rig& rig);

  /// Why the file could not be read; nothing if it could.
  const std::optional<std::string>& damage() const { return damage_; }

  /// Returns commands that bring the guards of a new run to the saved state: frozen cameras.
  std::vector<CalibrationCommand> restore_commands() const;

  /// Decides a request for calibrations and saves the decision. Errors: unknown camera or number,
  /// nothing to apply or to roll back, a camera with a fault, a file that cannot be written; then
  /// nothing has changed.
  Result<OwnerDecision> decide(const Request& request);

  /// Takes in a report of a guard: what is in use and proposed gets its number and is saved, and
  /// the report says which calibrations are known. A report of before the last decision changes
  /// nothing. Error: the file cannot be written; it is tried again with the next report.
  Result<void> observe(CalibrationReport& report);

 private:
  std::vector<std::string> cameras_of(const Request& request) const;
  Result<OwnerDecision> apply(const Request& request);
  Result<OwnerDecision> roll_back(const Request& request);
  Result<OwnerDecision> recalibrate(const Request& request);
  Result<OwnerDecision> freeze(const Request& request);
  void put_into_use(CameraCalibrations& camera, uint64_t number, bool rolls_back,
                    OwnerDecision& decision);
  KnownCalibration& learn(CameraCalibrations& camera, const Eigen::Isometry3d& T, Stamp stamp,
                          CalibrationOrigin origin);
  static void forget_oldest(CameraCalibrations& camera);
  void follow(CameraCalibrations& camera, const CalibrationReport& report);
  void restore(CameraMount& mount, std::vector<std::string>& lines);
  std::optional<SavedCalibrations> read(std::vector<std::string>& lines);
  static void describe(const CameraCalibrations& camera, CalibrationReport& report);
  Result<void> write();

  std::filesystem::path path_;
  SavedCalibrations saved_;
  std::vector<std::string> cameras_;               // of the rig
  std::map<std::string, uint64_t> decisions_;      // the last of each camera
  std::map<std::string, CalibrationReport> last_;  // report of each camera
  uint64_t next_decision_ = 1;
  bool unsaved_ = false;  // a change is not in the file
  std::optional<std::string> damage_;
};

}  // namespace infuse::daemon
