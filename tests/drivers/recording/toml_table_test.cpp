// TOML text from outside is refused where it would exhaust the stack.

#include "drivers/recording/toml_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace infuse::recording {
namespace {

std::string dotted_key(size_t parts, const std::string& part = "a") {
  std::string key = part;
  for (size_t i = 1; i < parts; ++i) key += "." + part;
  return key;
}

TEST(ParseToml, RefusesKeysOfManyParts) {
  for (const std::string part : {"a", "'a'", "\"a\""}) {
    for (const std::string& text :
         {dotted_key(100'000, part) + " = 1\n", "[" + dotted_key(100'000, part) + "]\n",
          "[[" + dotted_key(100'000, part) + "]]\n",
          "x = {" + dotted_key(100'000, part) + " = 1}\n"}) {
      const auto parsed = parse_toml("y = 1\n" + text, "drive.toml");
      ASSERT_FALSE(parsed);
      EXPECT_EQ(parsed.error().where, "drive.toml:2");
      EXPECT_THAT(parsed.error().what, testing::HasSubstr("a key has more than 256 parts"));
    }
  }
}

TEST(ParseToml, ReadsKeysOfSomePartsNumbersPathsAndComments) {
  std::string numbers = "0.5";
  for (int i = 0; i < 1000; ++i) numbers += ", 0.5";
  const std::string dots(1000, '.');
  const auto parsed = parse_toml(
      dotted_key(200) + " = [" + numbers + "]\n  # " + dots + "\npath = '../../../x.pcap'\n",
      "drive.toml");
  ASSERT_TRUE(parsed) << parsed.error().message();
  EXPECT_EQ((*parsed)["path"].value<std::string>(), "../../../x.pcap");
}

}  // namespace
}  // namespace infuse::recording
