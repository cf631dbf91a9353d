#include "daemon/protocol/request.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/daemon/schema.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

TEST(Request, ReadsEveryOp) {
  EXPECT_EQ(parse_request(R"({"op":"poll"})")->op, Request::Op::kPoll);
  EXPECT_EQ(parse_request(R"({"op":"devices"})")->op, Request::Op::kDevices);
  const auto watch = parse_request(R"( {"op":"watch", "classes":["HEALTH","ALERT"]} )"
                                   "\r");
  ASSERT_TRUE(watch);
  EXPECT_EQ(watch->op, Request::Op::kWatch);
  EXPECT_TRUE(watch->classes.has(ReportClass::kHealth));
  EXPECT_TRUE(watch->classes.has(ReportClass::kAlert));
  EXPECT_FALSE(watch->classes.has(ReportClass::kSweep));
}

TEST(Request, WatchWithoutClassesIsAllAndAnEmptyListIsNone) {
  EXPECT_EQ(parse_request(R"({"op":"watch"})")->classes, ReportClasses::all());
  EXPECT_EQ(parse_request(R"({"op":"watch","classes":[]})")->classes, ReportClasses());
}

TEST(Request, ControlRequestsNameACameraOrNone) {
  const auto freeze = parse_request(R"({"op":"freeze","device":"front","on":false})");
  ASSERT_TRUE(freeze);
  EXPECT_TRUE(freeze->is_control());
  EXPECT_EQ(freeze->op, Request::Op::kFreeze);
  EXPECT_EQ(freeze->device, "front");
  EXPECT_FALSE(freeze->on);
  EXPECT_EQ(parse_request(R"({"op":"apply"})")->device, "");
  EXPECT_FALSE(parse_request(R"({"op":"watch"})")->is_control());
  EXPECT_FALSE(parse_request(R"({"op":"rollback","device":7})"));
  EXPECT_FALSE(parse_request(R"({"op":"freeze","on":"yes"})"));
}

TEST(Request, ARecordingHasANameAndBounds) {
  const auto record =
      parse_request(R"({"op":"record","name":"x","duration_s":1.5,"max_bytes":2000000000})");
  ASSERT_TRUE(record);
  EXPECT_EQ(record->op, Request::Op::kRecord);
  EXPECT_TRUE(record->is_control());
  EXPECT_EQ(record->name, "x");
  EXPECT_EQ(record->max_duration, std::chrono::milliseconds(1500));
  EXPECT_EQ(record->max_bytes, 2'000'000'000U);
  EXPECT_FALSE(parse_request(R"({"op":"record","on":false})")->on);
}

TEST(Request, InvalidRequestsAreErrorsWithAReason) {
  EXPECT_THAT(parse_request("").error().what, HasSubstr("not a JSON object"));
  EXPECT_THAT(parse_request("[1]").error().what, HasSubstr("not a JSON object"));
  EXPECT_THAT(parse_request("{}").error().what, HasSubstr("no op"));
  EXPECT_THAT(parse_request(R"({"op":7})").error().what, HasSubstr("no op"));
  const auto unknown = parse_request(R"({"op":"dance"})");
  EXPECT_THAT(unknown.error().what, HasSubstr("unknown op 'dance'"));
  EXPECT_THAT(unknown.error().hint, HasSubstr("\"watch\""));
  const auto bad_class = parse_request(R"({"op":"watch","classes":["POINTS"]})");
  EXPECT_THAT(bad_class.error().what, HasSubstr("'POINTS'"));
  EXPECT_THAT(bad_class.error().hint, HasSubstr("\"SWEEP\""));
  EXPECT_EQ(bad_class.error().where, "watch");
  EXPECT_FALSE(parse_request(R"({"op":"watch","classes":"HEALTH"})"));
  EXPECT_FALSE(parse_request(R"({"op":"watch","classes":[7]})"));
}

TEST(Request, LengthAndDepthAreBounded) {
  const std::string deep =
      R"({"op":"poll","x":)" + std::string(2000, '[') + std::string(2000, ']') + "}";
  EXPECT_THAT(parse_request(deep).error().what, HasSubstr("nested"));
  EXPECT_TRUE(parse_request(R"({"op":"poll","x":[[[[1]]]]})"));
  const std::string padding(kMaxRequestBytes, ' ');
  EXPECT_THAT(parse_request(R"({"op":"poll"})" + padding).error().what, HasSubstr("longer"));
  EXPECT_LT(parse_request(R"({"op":")" + std::string(4000, 'x') + R"("})").error().what.size(),
            100U);
}

TEST(Request, TheSchemaAgreesWithTheParser) {
  for (const char* text :
       {R"({"op":"poll"})", R"({"op":"devices"})", R"({"op":"watch"})",
        R"({"op":"watch","classes":["SWEEP","DEVICES"]})", R"({"op":"apply"})",
        R"({"op":"record","name":"x","duration_s":1.5})", R"({"op":"record","name":7})",
        R"({"op":"record","duration_s":0})", R"({"op":"record","duration_s":"1"})",
        R"({"op":"record","max_bytes":-1})", R"({"op":"record","max_bytes":1.5})",
        R"({"op":"record","max_bytes":0})", R"({"op":"watch","classes":["sweep"]})", R"({})",
        R"({"op":"watch","classes":"SWEEP"})"}) {
    EXPECT_EQ(parse_request(text).has_value(),
              static_cast<bool>(matches_schema(nlohmann::json::parse(text), "protocol/request")))
        << text;
  }
}

TEST(Request, TenThousandMutatedLinesAreEachAcceptedOrRefusedWithAReason) {
  const std::string seeds[] = {R"({"op":"watch","classes":["HEALTH","ALERT","SWEEP"]})",
                               R"({"op":"poll"})", R"({"op":"devices","x":{"y":[1,2.5e3,null]}})"};
  std::mt19937 random(1);
  int accepted = 0;
  for (int i = 0; i < 10'000; ++i) {
    std::string line = seeds[random() % 3];
    for (unsigned edits = 1 + random() % 4; edits > 0; --edits) {
      const size_t place = random() % (line.size() + 1);
      switch (random() % 3) {
        case 0:
          line.insert(place, 1, static_cast<char>(random()));
          break;
        case 1:
          line.erase(place, random() % 8);
          break;
        default:
          if (place < line.size()) line[place] = static_cast<char>(random());
      }
    }
    const auto request = parse_request(line);
    accepted += request.has_value();
    if (!request) {
      EXPECT_FALSE(request.error().what.empty());
    }
  }
  EXPECT_GT(accepted, 0);
  EXPECT_LT(accepted, 9000);
}

}  // namespace
}  // namespace infuse::daemon
