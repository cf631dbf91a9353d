#include "drivers/vehicle/serial_line_source.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>

#include <cstdlib>
#include <vector>

namespace infuse::vehicle {
namespace {

TEST(LineSplitter, SplitsAtLineEndsForAnyChunking) {
  const std::string text = "\r\n$GPRMC,1*00\r\n\r\n$GPGGA,2*11\n$tail";
  for (size_t piece = 1; piece <= text.size(); ++piece) {
    LineSplitter splitter;
    std::vector<std::string> lines;
    for (size_t at = 0; at < text.size(); at += piece) {
      splitter.push(std::string_view(text).substr(at, piece), Stamp(),
                    [&](Stamp, std::string_view line) { lines.emplace_back(line); });
    }
    EXPECT_EQ(lines, (std::vector<std::string>{"$GPRMC,1*00", "$GPGGA,2*11"})) << piece;
  }
}

TEST(LineSplitter, StampsALineByItsFirstByte) {
  LineSplitter splitter;
  std::vector<int64_t> stamps;
  const auto note = [&](Stamp stamp, std::string_view) { stamps.push_back(stamp.ns()); };
  splitter.push("a\nb", Stamp::from_ns(1), note);
  splitter.push("b\n", Stamp::from_ns(2), note);
  splitter.push("\nc\n", Stamp::from_ns(3), note);
  EXPECT_EQ(stamps, (std::vector<int64_t>{1, 1, 3}));
}

TEST(LineSplitter, DropsALineThatIsTooLongAndContinues) {
  LineSplitter splitter;
  std::vector<std::string> lines;
  const std::string max_line(LineSplitter::kMaxLineLength, 'x');
  splitter.push(max_line + "\n" + max_line + "y\nz\n", Stamp(),
                [&](Stamp, std::string_view line) { lines.emplace_back(line); });
  EXPECT_EQ(lines, (std::vector<std::string>{max_line, "z"}));
  EXPECT_EQ(splitter.dropped(), 1U);
}

/// A pair of pseudo-terminals: bytes written to one are read from the other.
struct PseudoTerminal {
  host::FileDescriptor main{posix_openpt(O_RDWR | O_NOCTTY)};
  std::string device;

  PseudoTerminal() {
    EXPECT_EQ(grantpt(main.get()), 0);
    EXPECT_EQ(unlockpt(main.get()), 0);
    std::array<char, 64> name{};
    EXPECT_EQ(ptsname_r(main.get(), name.data(), name.size()), 0);
    device = name.data();
  }
  void write(std::string_view text) const {
    EXPECT_EQ(::write(main.get(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
};

bool wait_for(const SerialLineSource& source) {
  pollfd waiting{source.descriptor(), POLLIN, 0};
  return poll(&waiting, 1, 5000) == 1;
}

TEST(SerialLineSource, ReadsLinesAndReportsHangUp) {
  auto terminal = std::make_unique<PseudoTerminal>();
  auto source = SerialLineSource::open({terminal->device, 9600}, host::TimeBase());
  ASSERT_TRUE(source.has_value()) << source.error().message();
  std::vector<std::string> lines;
  const auto note = [&](Stamp, std::string_view line) { lines.emplace_back(line); };
  EXPECT_EQ(*source->read(note), 0U);
  terminal->write("$GPGGA,1*00\r\n$GP");
  ASSERT_TRUE(wait_for(*source));
  ASSERT_TRUE(source->read(note).has_value());
  EXPECT_EQ(lines, (std::vector<std::string>{"$GPGGA,1*00"}));
  terminal.reset();
  ASSERT_TRUE(wait_for(*source));
  EXPECT_FALSE(source->read(note).has_value());
}

TEST(SerialLineSource, RejectsNonSerialDevices) {
  const host::TimeBase base;
  EXPECT_FALSE(SerialLineSource::open({"/dev/null", 9600}, base).has_value());
  EXPECT_FALSE(SerialLineSource::open({"/dev/no-such-device", 9600}, base).has_value());
  EXPECT_TRUE((SerialOptions{"/dev/ttyUSB0", 1234}.invalid()));
  EXPECT_TRUE((SerialOptions{"ttyUSB0", 9600}.invalid()));
}

}  // namespace
}  // namespace infuse::vehicle
