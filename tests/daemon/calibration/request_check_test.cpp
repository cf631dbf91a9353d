#include "daemon/calibration/request_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace infuse::daemon {
namespace {

using testing::HasSubstr;
using Op = Request::Op;

TEST(RequestCheck, NothingToApplyOrToRollBackIsSaid) {
  std::map<std::string, CalibrationReport> calibrations;
  EXPECT_THAT(check_request({.op = Op::kApply}, calibrations)->what,
              HasSubstr("no new calibration"));
  calibrations["front"] = {};
  calibrations["rear"].proposed = true;
  calibrations["rear"].can_roll_back = true;
  EXPECT_THAT(check_request({.op = Op::kApply, .device = "front"}, calibrations)->what,
              HasSubstr("'front'"));
  EXPECT_TRUE(check_request({.op = Op::kRollback, .device = "front"}, calibrations));
  EXPECT_FALSE(check_request({.op = Op::kApply, .device = "rear"}, calibrations));
  EXPECT_FALSE(check_request({.op = Op::kApply}, calibrations));
  EXPECT_FALSE(check_request({.op = Op::kRollback}, calibrations));
  EXPECT_FALSE(check_request({.op = Op::kRecalibrate, .device = "front"}, calibrations));
  EXPECT_FALSE(check_request({.op = Op::kFreeze, .device = "front"}, calibrations));
}

}  // namespace
}  // namespace infuse::daemon
