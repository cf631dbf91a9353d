#include "drivers/vehicle/candump.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace infuse::vehicle {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr int64_t kStampNs = 1533226488'230547000;

TEST(Candump, ReadsEveryFormOfTheSameFrame) {
  // The frame as candump of can-utils 2020.11 writes it with -l, -L, on the screen with -ta, -ta
  // -x, -tA -a, and as in older or truncated logs.
  const std::string_view lines[] = {
      "(1533226488.230547) can0 260#08FFFB",
      "(1533226488.230547) can0 260#08FFFB R",
      "(1533226488.230547) 260#08.FF.FB",
      " (1533226488.230547)  can0  260   [3]  08 FF FB",
      " (1533226488.230547)  can0  RX - -  260   [3]  08 FF FB",
      " (2018-08-02 16:14:48.230547)  can0  260   [3]  08 FF FB   '...'\r",
      " (1533226488.230547)  260   [3]  08 FF FB",
      "(1533226488.230547000) can0 00000260#08FFFB",
  };
  for (const std::string_view line : lines) {
    const auto frame = parse_candump_line(line);
    ASSERT_TRUE(frame) << line << ": " << frame.error().message();
    EXPECT_EQ(frame->stamp.ns(), kStampNs) << line;
    EXPECT_EQ(frame->id, 0x260u);
    EXPECT_EQ(frame->extended, line.find("00000260") != line.npos);
    EXPECT_THAT(frame->payload(), ElementsAre(0x08, 0xFF, 0xFB)) << line;
    EXPECT_EQ(frame->interface_name(), line.find("can0") != line.npos ? "can0" : "") << line;
    EXPECT_FALSE(frame->remote || frame->error || frame->fd);
  }
}

TEST(Candump, ReadsWithoutTimeStamps) {
  for (const std::string_view line : {"can1 12345678#", "  can1  12345678   [0]"}) {
    const auto frame = parse_candump_line(line);
    ASSERT_TRUE(frame) << line;
    EXPECT_EQ(frame->stamp.ns(), 0);
    EXPECT_TRUE(frame->extended);
    EXPECT_EQ(frame->id, 0x12345678u);
    EXPECT_EQ(frame->length, 0);
  }
  EXPECT_EQ(parse_candump_line("7FF#00")->interface_name(), "");
}

TEST(Candump, ReadsFdRemoteAndErrorFrames) {
  const auto fd = parse_candump_line("(1.000000) can0 123##3000102030405060708090A0B");
  ASSERT_TRUE(fd) << fd.error().message();
  EXPECT_TRUE(fd->fd);
  EXPECT_EQ(fd->fd_flags, 3);
  EXPECT_EQ(fd->length, 12);
  EXPECT_EQ(fd->data[11], 0x0B);
  const auto screen = parse_candump_line("  can0  123  [12]  00 01 02 03 04 05 06 07 08 09 0A 0B");
  ASSERT_TRUE(screen);
  EXPECT_TRUE(screen->fd);
  EXPECT_EQ(screen->length, 12);
  for (const std::string_view line : {"can0 123#R4", "  can0  123   [4]  remote request"}) {
    const auto remote = parse_candump_line(line);
    ASSERT_TRUE(remote) << line;
    EXPECT_TRUE(remote->remote);
    EXPECT_EQ(remote->length, 4);
  }
  for (const std::string_view line :
       {"can0 20000004#000C000000000000",
        "  can0  20000004   [8]  00 0C 00 00 00 00 00 00   ERRORFRAME"}) {
    const auto error = parse_candump_line(line);
    ASSERT_TRUE(error) << line;
    EXPECT_TRUE(error->error);
    EXPECT_FALSE(error->extended);
    EXPECT_EQ(error->id, 4u);
    EXPECT_EQ(error->data[1], 0x0C);
  }
}

TEST(Candump, ReportsMalformedLines) {
  const std::pair<const char*, const char*> cases[] = {
      {"(1533226488.230547) can0 260#08F", "'F' is not a whole number of bytes"},
      {"(1533226488.230547) can0 260#0011223344556677AA", "more than 8 bytes"},
      {"(1533226488.230547) can0 26#08", "'26' is not an identifier"},
      {"(1533226488.230547) can0 FFF#08", "'FFF' is not an identifier"},
      {"(1533226488.230547) can0 8FFFFFFF#08", "is not an identifier"},
      {"(1533226488.230547 can0 260#08", "not closed"},
      {"(15x.230547) can0 260#08", "is not a time"},
      {"(99999999999.000000) can0 260#08", "is not a time"},
      {"(2018-13-02 16:14:48.230547) can0 260#08", "is not a time"},
      {"can0 123##", "flags are missing"},
      {"can0 123##1000102030405060708", "a CAN FD frame cannot have 9 bytes"},
      {"can0 123#R9", "remote request"},
      {"  can0  123   [3]  00 01", "byte 2 of 3 is ''"},
      {"  can0  123   [9]  00 01", "a frame cannot have 9 bytes"},
      {"hello", "no CAN frame in 'hello'"},
      {"one two three four five six seven#", "no CAN frame"},
  };
  for (const auto& [line, report] : cases) {
    const auto frame = parse_candump_line(line);
    ASSERT_FALSE(frame) << line;
    EXPECT_THAT(frame.error().message(), HasSubstr(report)) << line;
  }
}

TEST(Candump, WritesWhatItReads) {
  for (const std::string line :
       {"(1533226488.230547) can0 260#08FFFB", "(0000000001.000002) vcan1 1FFFFFFF#",
        "(1533226488.230547) can0 123##10001020304050607", "(1533226488.230547) can0 123#R4",
        "(1533226488.230547) can0 20000004#000C000000000000"}) {
    const auto frame = parse_candump_line(line);
    ASSERT_TRUE(frame) << line;
    EXPECT_EQ(format_candump_line(*frame), line);
  }
}

TEST(Candump, ReaderReportsBadLinesAndKeepsTheLinesAroundThem) {
  CandumpReader reader("can.log");
  std::vector<int64_t> stamps;
  for (const char* line :
       {"(1.000000) can0 001#01", "", "# a comment", "(2.0 can0 001#01", "(3.000000) can0 001#03",
        "(2.500000) can0 001#04", "(2.600000) can0 001#05", "garbage"}) {
    if (const auto frame = reader.read(line)) stamps.push_back(frame->stamp.ns() / 100'000'000);
  }
  EXPECT_THAT(stamps, ElementsAre(10, 30, 25, 26));
  EXPECT_EQ(reader.lines(), 8u);
  EXPECT_EQ(reader.frames(), 4u);
  ASSERT_EQ(reader.problems().count(), 3u);
  EXPECT_THAT(reader.problems().first()[0].message(), HasSubstr("can.log:4: "));
  EXPECT_THAT(reader.problems().first()[1].message(),
              HasSubstr("can.log:6: time goes back by 0.5"));
  EXPECT_THAT(reader.problems().first()[2].message(), HasSubstr("can.log:8: "));
}

}  // namespace
}  // namespace infuse::vehicle
