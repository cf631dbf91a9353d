#include "daemon/protocol/number_json.hpp"
#include "daemon/tools/fleet/fleet_summary.hpp"
#include "daemon/tools/fleet/json_fields.hpp"
#include "drivers/measurement/angles.hpp"

namespace infuse::daemon {
namespace {

constexpr int kFleetForm = 1;  // version of the summary

/// Six numbers as degrees and metres.
Json degrees_json(const geometry::Vector6& values) {
  geometry::Vector6 scaled = values;
  scaled.head<3>() /= kDegree;
  return by_row(scaled);
}

geometry::Vector6 sigma_of(const geometry::Matrix6& covariance) {
  return covariance.diagonal().cwiseMax(0).cwiseSqrt();
}

Json change_json(const CameraSummary& camera, const calibration::PoseChange& change) {
  const CameraDrive& first = camera.drives[change.first];
  const CameraDrive& before = camera.drives[change.first - 1];
  return {{"kind", change.kind == calibration::ChangeKind::kStep ? "step" : "ramp"},
          {"begins", date_of(first.stamp)},
          {"begins_stamp", first.stamp.ns()},
          {"first_drive", first.drive},
          {"last_drive_before", before.drive},
          {"complete", date_of(camera.drives[change.last].stamp)},
          {"axis", calibration::kPoseAxes[static_cast<size_t>(change.axis)]},
          {"axis_share", change.share},
          {"change_deg_m", degrees_json(change.change)},
          {"sigma_deg_m", degrees_json(change.sigma)},
          {"p_value", change.p_value}};
}

Json drives_json(const CameraSummary& camera) {
  Json drives = Json::array();
  const Eigen::Isometry3d& T = camera.T_rig ? *camera.T_rig : camera.history.all.T_camera_lidar;
  for (const CameraDrive& drive : camera.drives) {
    const geometry::Vector6 offset = geometry::log(drive.calibration.T_camera_lidar * T.inverse());
    drives.push_back({{"drive", drive.drive},
                      {"stamp", drive.stamp.ns()},
                      {"offset_deg_m", degrees_json(offset)},
                      {"sigma_deg_m", degrees_json(sigma_of(drive.calibration.covariance))}});
  }
  return drives;
}

Json camera_json(const CameraSummary& camera) {
  const calibration::PoseHistory& history = camera.history;
  Json json = {{"camera", camera.camera},
               {"lidar", camera.lidar},
               {"verdict", name_of(history.verdict)},
               {"what", describe(camera)},
               {"usable", history.usable()},
               {"reason", history.reason},
               {"chi_squared", history.all.chi_squared},
               {"degrees_of_freedom", history.all.degrees_of_freedom},
               {"p_value", history.all.p_value},
               {"scale", history.scale},
               {"left_out", camera.left_out},
               {"changes", Json::array()},
               {"drives", drives_json(camera)},
               {"unusable", Json::array()}};
  for (const auto& change : history.changes) json["changes"].push_back(change_json(camera, change));
  for (const CameraDrive& drive : camera.unusable) {
    json["unusable"].push_back({{"drive", drive.drive}, {"reason", drive.calibration.reason}});
  }
  if (!history.usable()) return json;
  json["T_camera_lidar"] = by_row(history.current.T_camera_lidar.matrix());
  json["covariance"] = rows_json(camera.covariance);
  json["covariance_of_drives"] = rows_json(history.current.covariance);
  if (camera.rig) {
    json["rig"] = {{"differs", camera.rig->differs},
                   {"offset_deg_m", degrees_json(camera.rig->offset)},
                   {"p_value", camera.rig->p_value}};
  }
  return json;
}

}  // namespace

Json to_json(const FleetSummary& fleet) {
  Json json = {{"form", kFleetForm},
               {"drives", fleet.drives},
               {"vehicles", Json::array()},
               {"failed", Json::array()}};
  for (const VehicleSummary& vehicle : fleet.vehicles) {
    Json one = {{"vehicle", vehicle.name},
                {"verdict", name_of(vehicle.verdict())},
                {"differs_from_rig", vehicle.differs_from_rig()},
                {"drives", vehicle.drives},
                {"failed_drives", vehicle.failed},
                {"driven_s", vehicle.driven_s},
                {"alerts", vehicle.alerts},
                {"cameras", Json::array()}};
    for (const CameraSummary& camera : vehicle.cameras)
      one["cameras"].push_back(camera_json(camera));
    json["vehicles"].push_back(std::move(one));
  }
  for (const FailedDrive& failed : fleet.failed) {
    json["failed"].push_back({{"vehicle", failed.vehicle},
                              {"drive", failed.drive},
                              {"step", failed.failure.step},
                              {"what", failed.failure.what}});
  }
  return json;
}

}  // namespace infuse::daemon
