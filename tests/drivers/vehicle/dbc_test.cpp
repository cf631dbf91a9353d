#include "drivers/vehicle/dbc.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/real_data.hpp"

namespace infuse::vehicle {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

constexpr char kDbcText[] = R"(VERSION ""

NS_ :
    CM_
    VAL_
BS_:
BU_: ECU

BO_ 256 BOTH_ORDERS: 8 ECU
 SG_ INTEL_12 : 4|12@1+ (0.5,-10) [0|0] "m" ECU
 SG_ MOTOROLA_12 : 19|12@0+ (1,0) [0|0] "" ECU,XXX
 SG_ SIGNED_INTEL : 32|5@1- (1,0) [-16|15] "" ECU
 SG_ SIGNED_MOTOROLA : 55|16@0- (0.01,0) [0|0] "deg" ECU

BO_ 2566834709 EXTENDED: 8 ECU
 SG_ SELECT M : 0|4@1+ (1,0) [0|15] "" ECU
 SG_ A m0 : 8|8@1+ (1,0) [0|255] "" ECU
 SG_ B m1M : 8|8@1+ (1,0) [0|255] "" ECU
 SG_ C m3 : 16|8@1+ (2,0) [0|255] "" ECU

BO_ 512 FLOATS: 12 ECU
 SG_ F : 0|32@1- (1,0) [0|0] "" ECU
 SG_ D : 39|64@0- (2,1) [0|0] "" ECU

CM_ SG_ 256 INTEL_12 "two
lines; with \"quotes\" in them";
VAL_ 256 SIGNED_INTEL -1 "minus one" 3 "three" ;
SIG_VALTYPE_ 512 F : 1;
SIG_VALTYPE_ 512 D : 2;
SG_MUL_VAL_ 2566834709 C B 3-5, 9-9;
)";

DbcParseResult parse_test_dbc() { return parse_dbc(kDbcText, "test.dbc"); }

std::optional<double> value(const Dbc& dbc, const char* message, const char* signal,
                            std::vector<uint8_t> payload) {
  const DbcMessage& owner = *dbc.find(message);
  return decode(owner, *owner.find_signal(signal), payload);
}

TEST(Dbc, ReadsMessagesAndSignals) {
  const DbcParseResult read = parse_test_dbc();
  EXPECT_EQ(read.problems.count(), 0u) << read.problems.first()[0].message();
  ASSERT_THAT(read.dbc.messages(), SizeIs(3));
  const DbcMessage* extended = read.dbc.find(0x18FECA15, true);
  ASSERT_NE(extended, nullptr);
  EXPECT_EQ(extended->name, "EXTENDED");
  EXPECT_EQ(read.dbc.find(0x18FECA15, false), nullptr);
  const DbcSignal* intel = read.dbc.find("BOTH_ORDERS")->find_signal("INTEL_12");
  ASSERT_NE(intel, nullptr);
  EXPECT_EQ(intel->unit, "m");
  EXPECT_EQ(intel->scale, 0.5);
}

// Expected values are derived by hand from the bit layouts.
TEST(Dbc, DecodesBothByteOrdersAndSigns) {
  const DbcParseResult read = parse_test_dbc();
  const std::vector<uint8_t> payload = {0x50, 0xAB, 0xFC, 0xDE, 0x1F, 0x00, 0xFF, 0x38};
  // Bits 4..15, least significant first: 0xAB5 = 2741.
  EXPECT_EQ(value(read.dbc, "BOTH_ORDERS", "INTEL_12", payload), 2741 * 0.5 - 10);
  // Starts at byte 2 bit 3 and runs into byte 3: 0xC then 0xDE.
  EXPECT_EQ(value(read.dbc, "BOTH_ORDERS", "MOTOROLA_12", payload), 0xCDE);
  EXPECT_EQ(value(read.dbc, "BOTH_ORDERS", "SIGNED_INTEL", payload), -1);
  EXPECT_EQ(value(read.dbc, "BOTH_ORDERS", "SIGNED_MOTOROLA", payload), -200 * 0.01);
  EXPECT_EQ(value(read.dbc, "BOTH_ORDERS", "SIGNED_MOTOROLA", {0, 0, 0, 0, 0, 0, 0}), std::nullopt)
      << "the payload ends before the signal";
}

TEST(Dbc, DecodesMultiplexedSignalsOnlyIfSelected) {
  const DbcParseResult read = parse_test_dbc();
  EXPECT_EQ(value(read.dbc, "EXTENDED", "A", {0, 7, 9}), 7);
  EXPECT_EQ(value(read.dbc, "EXTENDED", "B", {0, 7, 9}), std::nullopt);
  EXPECT_EQ(value(read.dbc, "EXTENDED", "B", {1, 4, 9}), 4);
  EXPECT_EQ(value(read.dbc, "EXTENDED", "C", {1, 4, 9}), 18) << "selected by B in 3-5";
  EXPECT_EQ(value(read.dbc, "EXTENDED", "C", {1, 9, 9}), 18) << "selected by B being 9";
  EXPECT_EQ(value(read.dbc, "EXTENDED", "C", {1, 6, 9}), std::nullopt);
  EXPECT_EQ(value(read.dbc, "EXTENDED", "C", {0, 4, 9}), std::nullopt) << "B itself is not there";
}

TEST(Dbc, DecodesFloats) {
  const DbcParseResult read = parse_test_dbc();
  // 1.5f = 0x3FC00000, -2.0 = 0xC000000000000000.
  const std::vector<uint8_t> payload = {0, 0, 0xC0, 0x3F, 0xC0, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(value(read.dbc, "FLOATS", "F", payload), 1.5);
  EXPECT_EQ(value(read.dbc, "FLOATS", "D", payload), -2.0 * 2 + 1);
}

TEST(Dbc, EncodingDecodesBackAndKeepsOtherBits) {
  std::mt19937_64 random(7);
  for (int trial = 0; trial < 4000; ++trial) {
    DbcMessage message;
    message.length = 8;
    DbcSignal signal;
    signal.length = static_cast<uint16_t>(1 + random() % 52);
    signal.byte_order = trial % 2 == 0 ? ByteOrder::kIntel : ByteOrder::kMotorola;
    signal.type = trial % 3 == 0 ? SignalType::kSigned : SignalType::kUnsigned;
    signal.start_bit = static_cast<uint16_t>(random() % 64);
    CanFrame frame = make_frame(message, {});
    if (!raw_value(signal, frame.payload())) continue;
    for (uint8_t& byte : frame.data) byte = static_cast<uint8_t>(random());
    const CanFrame before = frame;
    const double limit = std::ldexp(1.0, signal.length - 1);
    const double wanted = signal.type == SignalType::kSigned
                              ? static_cast<double>(random() % static_cast<uint64_t>(limit)) - limit
                              : static_cast<double>(random() % static_cast<uint64_t>(2 * limit));
    ASSERT_TRUE(encode(signal, wanted, std::span(frame.data).first(8)));
    EXPECT_EQ(decode(message, signal, frame.payload()), wanted);
    int changed = 0;
    for (size_t i = 0; i < 64; ++i) changed += __builtin_popcount(frame.data[i] ^ before.data[i]);
    EXPECT_LE(changed, signal.length);
  }
}

TEST(Dbc, EncodesTheBytesDerivedByHand) {
  const DbcParseResult read = parse_test_dbc();
  const DbcMessage& message = *read.dbc.find("BOTH_ORDERS");
  CanFrame frame = make_frame(message, Stamp::from_ns(5));
  EXPECT_EQ(frame.length, 8);
  EXPECT_FALSE(frame.fd);
  const auto payload = std::span(frame.data).first(frame.length);
  ASSERT_TRUE(encode(*message.find_signal("INTEL_12"), 2741 * 0.5 - 10, payload));
  ASSERT_TRUE(encode(*message.find_signal("MOTOROLA_12"), 0xCDE, payload));
  ASSERT_TRUE(encode(*message.find_signal("SIGNED_INTEL"), -1e9, payload)) << "held to -16";
  ASSERT_TRUE(encode(*message.find_signal("SIGNED_MOTOROLA"), -2.004, payload));
  EXPECT_THAT(payload, testing::ElementsAre(0x50, 0xAB, 0x0C, 0xDE, 0x10, 0, 0xFF, 0x38));
  EXPECT_FALSE(encode(*message.find_signal("INTEL_12"), std::nan(""), payload));
  EXPECT_FALSE(encode(*message.find_signal("INTEL_12"), 0, payload.first(1)));
}

struct Damage {
  const char* from;
  const char* to;
  const char* report;
};

// Each kind of damage is reported once with its line, and the statements around it are still read.
TEST(Dbc, ReportsWhatIsWrongAndReadsTheRest) {
  const Damage damages[] = {
      {"INTEL_12 : 4|12", "INTEL_12 : 4/12", "test.dbc:10: expected '|'"},
      {"INTEL_12 : 4|12", "INTEL_12 : 60|12", "does not fit into its message"},
      {"INTEL_12 : 4|12", "INTEL_12 : 4|0", "length out of range"},
      {"(0.5,-10)", "(0,-10)", "the factor is 0"},
      {"(0.5,-10)", "(half,-10)", "expected the factor, found 'half'"},
      {"[0|0] \"m\" ECU", "[0|0] \"m ECU", "a string is not closed"},
      {" SG_ INTEL_12", " SG_ MOTOROLA_12", "BOTH_ORDERS.MOTOROLA_12 is defined twice"},
      {"SIG_VALTYPE_ 512 D : 2;", "SIG_VALTYPE_ 512 D : 2", "expected ';'"},
      {"\"quotes\\\" in them\"", "\"quotes\\\" in them", "a string is not closed"},
      {"SELECT M", "SELECT Q", "'Q' is not a multiplexor indicator"},
      {"BO_ 256", "nonsense here\nBO_ 256", "'nonsense' does not open a statement"},
      {"C B 3-5", "C NONE 3-5", "its multiplexor is missing"},
      {"BOTH_ORDERS: 8", "BOTH_ORDERS: 65", "longer than 64 bytes"},
      {"BO_ 512", "BO_ 256", "another message has the same id"},
  };
  for (const Damage& damage : damages) {
    std::string text = kDbcText;
    const size_t at = text.find(damage.from);
    if (at == std::string::npos) {
      ADD_FAILURE() << damage.from;
      continue;
    }
    text.replace(at, std::string(damage.from).size(), damage.to);
    const DbcParseResult read = parse_dbc(text, "test.dbc");
    ASSERT_GE(read.problems.count(), 1u) << damage.to;
    EXPECT_THAT(read.problems.first()[0].message(), HasSubstr(damage.report));
    ASSERT_NE(read.dbc.find("EXTENDED"), nullptr) << damage.to;
    EXPECT_EQ(value(read.dbc, "EXTENDED", "A", {0, 7, 9}),
              std::string(damage.to) == "SELECT Q" ? std::nullopt : std::optional(7.0))
        << damage.to;
    if (std::string(damage.to).find("BO_ 256") != 0 &&
        std::string(damage.to).find("65") == std::string::npos) {
      EXPECT_NE(read.dbc.find("FLOATS"), nullptr) << damage.to;
      EXPECT_NE(read.dbc.find("BOTH_ORDERS")->find_signal("SIGNED_INTEL"), nullptr) << damage.to;
    }
  }
}

TEST(Dbc, KeepsTheListOfProblemsBounded) {
  std::string text;
  for (int i = 0; i < 1000; ++i) text += "rubbish " + std::to_string(i) + "\n" + "BO_ x\n";
  const DbcParseResult read = parse_dbc(text, "bad.dbc");
  EXPECT_GE(read.problems.count(), 1000u);
  EXPECT_THAT(read.problems.first(), SizeIs(ProblemLog::kMaxKept));
}

TEST(Dbc, ReportsMissingFile) {
  const auto read = read_dbc("/nonexistent/x.dbc");
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().message(), HasSubstr("/nonexistent/x.dbc"));
}

TEST(Dbc, ReadsTheWholeRealRav4File) {
  INFUSE_REAL_DATA_OR_SKIP(path, "can/rav4/vehicle.dbc");
  const auto read = read_dbc(path);
  ASSERT_TRUE(read);
  for (const Error& problem : read->problems.first()) ADD_FAILURE() << problem.message();
  const DbcMessage* wheels = read->dbc.find(0xAA, false);
  ASSERT_NE(wheels, nullptr);
  EXPECT_EQ(wheels->name, "WHEEL_SPEEDS");
  const DbcMessage* gear = read->dbc.find("GEAR_PACKET");
  ASSERT_NE(gear, nullptr);
}

}  // namespace
}  // namespace infuse::vehicle
