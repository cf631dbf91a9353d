#include "drivers/text/stamp_text.hpp"

#include <gtest/gtest.h>

namespace infuse::text {
namespace {

TEST(ParseStamp, ParsesSecondsExactly) {
  EXPECT_EQ(parse_stamp("1436509052.249713")->ns(), 1'436'509'052'249'713'000);
  EXPECT_EQ(parse_stamp("0.5")->ns(), 500'000'000);
  EXPECT_EQ(parse_stamp("-0.5")->ns(), -500'000'000);
  EXPECT_EQ(parse_stamp("7")->ns(), 7'000'000'000);
  EXPECT_EQ(parse_stamp("1.0000000019")->ns(), 1'000'000'001);
}

TEST(ParseStamp, ParsesExponents) {
  EXPECT_EQ(parse_stamp("1.037359e-01")->ns(), 103'735'900);
  EXPECT_EQ(parse_stamp("1E3")->ns(), 1'000'000'000'000);
}

TEST(ParseStamp, ParsesUtcDates) {
  EXPECT_EQ(parse_stamp("2018-08-02 16:14:48.230547")->ns(), 1'533'226'488'230'547'000);
  EXPECT_EQ(parse_stamp("2011-09-26 13:02:25.964389445")->ns(), 1'317'042'145'964'389'445);
  EXPECT_EQ(parse_stamp("1970-01-01 00:00:00")->ns(), 0);
}

TEST(ParseStamp, RejectsMalformedAndOutOfRangeText) {
  for (const char* bad :
       {"", ".", "-", "x", "1x", "1.x", "1.5.5", "--1", " 1.5", "99999999999.0", "1e10", "nan",
        "2018-13-02 16:14:48.2", "2018-02-30 16:14:48.2", "2018-08-02 24:14:48", "2018-08-02 16:14",
        "2018-08-02 16:14:61", "2018-08-02 16:14:-8", "9999-08-02 16:14:48"}) {
    EXPECT_FALSE(parse_stamp(bad)) << bad;
  }
}

}  // namespace
}  // namespace infuse::text
