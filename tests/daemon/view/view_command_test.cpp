#include "daemon/view/view_command.hpp"

#include <gtest/gtest.h>

namespace infuse::daemon {
namespace {

using Kind = ViewCommand::Kind;

TEST(ViewCommand, ReadsWhatAPageMayAskFor) {
  EXPECT_EQ(parse_view_command(R"({"rate":2.5})"), (ViewCommand{.kind = Kind::kRate, .rate = 2.5}));
  EXPECT_EQ(parse_view_command(R"({"rate":0})"), (ViewCommand{.kind = Kind::kRate, .rate = 0}));
  EXPECT_EQ(parse_view_command(R"({"step":true})"), ViewCommand{.kind = Kind::kStep});
  EXPECT_EQ(parse_view_command(R"({"seek":"1700000000123456789"})"),
            (ViewCommand{.kind = Kind::kSeek, .stamp = Stamp::from_ns(1'700'000'000'123'456'789)}));
  EXPECT_EQ(parse_view_command(R"({"seek":"alert"})"), ViewCommand{.kind = Kind::kSeekAlert});
}

TEST(ViewCommand, EverythingElseIsIgnored) {
  for (const char* text : {"",
                           "[[[[",
                           "null",
                           "{}",
                           "[]",
                           "\"seek\"",
                           R"({"rate":-1})",
                           R"({"rate":101})",
                           R"({"rate":1e999})",
                           R"({"rate":"2"})",
                           R"({"rate":null})",
                           R"({"step":1})",
                           R"({"step":false})",
                           R"({"seek":1700000000123456789})",
                           R"({"seek":""})",
                           R"({"seek":"-5"})",
                           R"({"seek":" 5"})",
                           R"({"seek":"5x"})",
                           R"({"seek":"99999999999999999999"})",
                           R"({"seek":"Alert"})",
                           R"({"op":"apply"})",
                           R"({"rate":1,"op":"apply"})",
                           R"({"rate":{"rate":1}})"}) {
    EXPECT_FALSE(parse_view_command(text)) << text;
  }
}

TEST(ViewCommand, AskingForProfilesIsNoCommand) {
  EXPECT_EQ(parse_profiles_wanted(R"({"profiles":true})"), true);
  EXPECT_EQ(parse_profiles_wanted(R"({"profiles":false})"), false);
  for (const char* text :
       {"", "[[[[", "true", "{}", "[true]", R"({"profiles":1})", R"({"profiles":"true"})",
        R"({"profiles":true,"rate":0})", R"({"rate":0})"}) {
    EXPECT_FALSE(parse_profiles_wanted(text)) << text;
  }
  EXPECT_FALSE(parse_view_command(R"({"profiles":true})"));
}

}  // namespace
}  // namespace infuse::daemon
