#include "drivers/text/numbers.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace infuse::text {
namespace {

TEST(ParseNumber, RequiresOneFiniteNumber) {
  EXPECT_EQ(parse_number("-1.5e3"), -1500.0);
  EXPECT_EQ(parse_integer("-42"), -42);
  EXPECT_EQ(parse_as<uint8_t>("255"), 255);
  EXPECT_TRUE(std::isnan(parse_number_or_nan("")));
  for (const char* bad : {"", " 1", "1 ", "1x", "nan", "inf", "1e999"}) {
    EXPECT_FALSE(parse_number(bad)) << bad;
  }
  EXPECT_FALSE(parse_as<uint8_t>("256"));
  EXPECT_FALSE(parse_integer("1.0"));
}

TEST(ParseNumbers, SplitsAtBlanks) {
  EXPECT_EQ(parse_numbers(" 1 2.5\t-3\r"), (std::vector<double>{1, 2.5, -3}));
  EXPECT_EQ(parse_numbers(""), std::vector<double>());
  EXPECT_FALSE(parse_numbers("1 x"));
}

TEST(AppendNumber, RoundTripsExactly) {
  std::string digits;
  append_number(digits, 0.1 + 0.2);
  EXPECT_EQ(parse_number(digits), 0.1 + 0.2);
  append_number(digits = "n=", 7);
  EXPECT_EQ(digits, "n=7");
}

}  // namespace
}  // namespace infuse::text
