#include "daemon/tools/fleet/fleet_summary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "daemon/tools/fleet/fleet_page.hpp"
#include "tests/daemon/tools/fleet/fleet_files.hpp"

namespace infuse::daemon {
namespace {

using calibration::PoseVerdict;
using fleet_files::entry;
using geometry::Vector6;
using testing::HasSubstr;
using testing::Not;

/// A deviation of a fraction of σ that differs from drive to drive.
Vector6 scatter(int drive) {
  Vector6 deviation;
  for (int k = 0; k < 6; ++k) {
    deviation(k) = 0.6 * std::sin(2.1 * drive + 1.3 * k) * (k < 3 ? 7e-4 : 5e-3);
  }
  return deviation;
}

std::string date(int drive) { return "2026-03-0" + std::to_string(drive + 1); }

/// Six drives of a car; from `moves` on its camera is turned by 0.4° about y.
void add_car(const std::string& name, int moves, std::vector<DriveEntry>& entries) {
  for (int i = 0; i < 6; ++i) {
    const Vector6 moved = i < moves ? Vector6::Zero() : Vector6(0.007 * Vector6::Unit(1));
    entries.push_back(entry(name, "drive" + std::to_string(i), date(i), moved + scatter(i)));
  }
}

Rig rig_with_front(const Eigen::Isometry3d& T_camera_lidar) {
  Rig rig;
  rig.cameras.emplace_back();
  rig.cameras[0].name = "front";
  rig.cameras[0].T_camera_lidar = T_camera_lidar;
  return rig;
}

TEST(FleetSummary, NamesTheVehicleTheDateAndTheAxis) {
  std::vector<DriveEntry> entries;
  add_car("good", 6, entries);
  add_car("knocked", 3, entries);
  const FleetSummary fleet = summarise_fleet(entries, {}, {});
  ASSERT_EQ(fleet.vehicles.size(), 2U);
  EXPECT_EQ(fleet.vehicles[0].verdict(), PoseVerdict::kOnePose);
  EXPECT_EQ(fleet.vehicles[1].verdict(), PoseVerdict::kDrift);
  EXPECT_THAT(describe(fleet.vehicles[1].cameras[0]),
              HasSubstr("drift from 2026-03-04 on: rotation about y by +0.4"));
  const Json json = to_json(fleet);
  const Json& change = json["vehicles"][1]["cameras"][0]["changes"][0];
  EXPECT_EQ(change["begins"], "2026-03-04");
  EXPECT_EQ(change["last_drive_before"], "drive2");
  EXPECT_EQ(change["axis"], "rotation about y");
  EXPECT_NEAR(change["change_deg_m"][1].get<double>(), 0.401, 0.05);
  EXPECT_GT(change["axis_share"].get<double>(), 0.9);
}

TEST(FleetSummary, TheOrderOfTheEntriesDoesNotMatter) {
  std::vector<DriveEntry> entries;
  add_car("a", 3, entries);
  add_car("b", 6, entries);
  const FleetSummary sorted = summarise_fleet(entries, {}, {});
  std::mt19937_64 random(1);
  std::shuffle(entries.begin(), entries.end(), random);
  const FleetSummary shuffled = summarise_fleet(entries, {}, {});
  EXPECT_EQ(to_json(sorted).dump(), to_json(shuffled).dump());
  EXPECT_EQ(make_fleet_page(sorted), make_fleet_page(shuffled));
}

TEST(FleetSummary, WhatDrivesShareStaysInTheCovariance) {
  std::vector<DriveEntry> entries;
  add_car("car", 6, entries);
  const FleetSummary fleet = summarise_fleet(entries, {}, {});
  const CameraSummary& camera = fleet.vehicles[0].cameras[0];
  // Six drives: σ² / 6 of the scenes, and the whole of the intrinsics.
  EXPECT_NEAR(camera.covariance(0, 0), 7e-4 * 7e-4 / 6 + 1.7e-3 * 1.7e-3, 1e-10);
  EXPECT_NEAR(camera.covariance(1, 1), 7e-4 * 7e-4 / 6, 1e-10);
}

TEST(FleetSummary, APoseOffTheRigIsSaid) {
  std::vector<DriveEntry> entries;
  add_car("car", 6, entries);
  const auto verdict = [&](const Vector6& stated) {
    const FleetSummary fleet =
        summarise_fleet(entries, {{"car", rig_with_front(geometry::exp(stated))}}, {});
    EXPECT_EQ(fleet.vehicles[0].verdict(), PoseVerdict::kOnePose);
    return fleet.vehicles[0].differs_from_rig();
  };
  EXPECT_FALSE(verdict(Vector6::Zero()));
  EXPECT_TRUE(verdict(0.007 * Vector6::Unit(1)));
  // About x the intrinsics explain as much: 0.2° are two sigma.
  EXPECT_FALSE(verdict(0.0035 * Vector6::Unit(0)));
}

TEST(FleetSummary, FailedDrivesAreNamedAndTheRestIsPooled) {
  std::vector<DriveEntry> entries;
  add_car("car", 6, entries);
  entries.push_back({.vehicle = "car",
                     .drive = "<b>&",
                     .stamp = std::nullopt,
                     .failures = {{"calibrate", "lidar.pcap: damaged at byte 7"}}});
  entries.push_back({.vehicle = "other", .drive = "x", .failures = {{"entry", "is none"}}});
  const FleetSummary fleet = summarise_fleet(entries, {}, {});
  EXPECT_EQ(fleet.vehicles[0].verdict(), PoseVerdict::kOnePose);
  EXPECT_EQ(fleet.vehicles[0].failed, 1U);
  EXPECT_EQ(fleet.vehicles[1].verdict(), PoseVerdict::kNone);
  ASSERT_EQ(fleet.failed.size(), 2U);
  const std::string page = make_fleet_page(fleet);
  EXPECT_THAT(page, HasSubstr("lidar.pcap: damaged at byte 7"));
  EXPECT_THAT(page, HasSubstr("&lt;b>&amp;"));
  EXPECT_THAT(page, Not(HasSubstr("<b>&")));
}

TEST(FleetPage, DrawsEveryDriveOnEveryAxisAndLoadsNothing) {
  std::vector<DriveEntry> entries;
  add_car("car", 3, entries);
  const std::string page = make_fleet_page(summarise_fleet(entries, {}, {}));
  const auto count = [&](const std::string& what) {
    size_t found = 0;
    for (size_t at = page.find(what); at != page.npos; at = page.find(what, at + 1)) ++found;
    return found;
  };
  EXPECT_EQ(count("<svg "), 6U);
  EXPECT_EQ(count("<circle "), 36U);
  EXPECT_EQ(count("<line class=change "), 6U);
  EXPECT_EQ(count("<script"), 0U);
  EXPECT_EQ(count("http"), 1U) << "of http-equiv";
  EXPECT_EQ(count("nan"), 0U);
  EXPECT_EQ(count("inf"), 0U);
}

TEST(FleetSummary, AFleetWithoutAnythingIsSaid) {
  const FleetSummary fleet = summarise_fleet({}, {}, {});
  EXPECT_EQ(to_json(fleet)["drives"], 0);
  EXPECT_THAT(make_fleet_page(fleet), HasSubstr("0 drives of 0 vehicles"));
}

}  // namespace
}  // namespace infuse::daemon
