// Sweeps from made packets: order, loss, wrap-around, windows, restarts.

#include "drivers/ouster/turn_assembler.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/allocation_counter.hpp"
#include "tests/drivers/ouster/made_metadata.hpp"
#include "tests/drivers/ouster/made_packet.hpp"

namespace infuse::ouster {
namespace {

constexpr int64_t kEpoch = 1'700'000'000'000'000'000;

/// A sensor that sends made packets, and the sweeps that become of them. Ranges are 1000 mm + the
/// measurement id, of two beams of eight.
class Turns {
 public:
  explicit Turns(MadeMetadata values = {}, double cut_azimuth = 180)
      : metadata_(parse_metadata(made_metadata(values), "").value()),
        assembler_(metadata_, {.cut_azimuth = cut_azimuth}, clock_options(), counters_, losses_) {}

  /// Sends the packet that begins with a column of a turn.
  void send(uint32_t turn, int first, uint64_t invalid_columns = 0) {
    const int64_t column = int64_t{turn} * metadata_.columns_per_turn + first;
    push({.frame_id = turn,
          .first_measurement_id = static_cast<uint16_t>(first),
          .device_ns = 1'000'000'000 + column * column_ns(),
          .column_ns = column_ns(),
          .invalid_columns = invalid_columns,
          .pixel = pixel});
  }
  /// Sends all packets of a turn's window.
  void send_turn(uint32_t turn, int first = 0, int end = 1024) {
    for (; first < end; first += metadata_.columns_per_packet) send(turn, first);
  }
  void push(const MadePacket& packet) {
    const auto payload = made_packet(metadata_, packet);
    const Stamp stamp = Stamp::from_ns(kEpoch + packet.device_ns + 16 * packet.column_ns);
    assembler_.push({stamp, 1, 7502, 7502, payload}, {});
    pull();
  }
  void finish() {
    assembler_.finish();
    pull();
  }

  int64_t column_ns() const { return 100'000'000 / metadata_.columns_per_turn; }
  const Metadata& metadata() const { return metadata_; }
  TurnAssembler& assembler() { return assembler_; }
  std::vector<Sweep> sweeps;
  const lidar::PacketCounters& counters() const { return counters_; }

  static MadePixel pixel(uint16_t id, size_t beam) {
    return beam % 8 < 2 ? MadePixel{8u * id + 8000, 0, 51, 0, 0} : MadePixel{};
  }

 private:
  static ClockModelOptions clock_options() {
    ClockModelOptions options;
    options.modulo = Duration(0);
    return options;
  }
  void pull() {
    while (assembler_.pull(sweep_)) sweeps.push_back(std::exchange(sweep_, {}));
  }

  Metadata metadata_;
  lidar::PacketCounters counters_;
  lidar::Losses losses_{counters_};
  TurnAssembler assembler_;
  Sweep sweep_;
};

/// The sweep's columns are those of the window in order, each with its returns and time.
void expect_columns(const Turns& turns, const Sweep& sweep, const std::vector<int>& columns,
                    int first_id) {
  const size_t returns_per_column = turns.metadata().beams() / 4;
  ASSERT_EQ(sweep.size(), columns.size() * returns_per_column);
  for (size_t i = 0; i < sweep.size(); ++i) {
    const int column = columns[i / returns_per_column];
    const int id = (first_id + column) % turns.metadata().columns_per_turn;
    ASSERT_EQ(sweep.column[i], column);
    ASSERT_EQ(sweep.time_offset_ns[i], (column - columns[0]) * turns.column_ns());
    ASSERT_FLOAT_EQ(sweep.range[i], static_cast<float>(8 * id + 8000) / 1000.0F);
    ASSERT_FLOAT_EQ(sweep.reflectivity[i], 0.2F);
  }
}

std::vector<int> range(int begin, int end) {
  std::vector<int> numbers;
  for (int i = begin; i < end; ++i) numbers.push_back(i);
  return numbers;
}

TEST(OusterTurnAssembler, MakesASweepOfEachTurn) {
  Turns turns;
  for (const uint32_t turn : {65'534u, 65'535u, 65'536u, 65'537u}) turns.send_turn(turn);
  turns.finish();
  ASSERT_EQ(turns.sweeps.size(), 4u);
  for (size_t i = 0; i < 4; ++i) {
    const Sweep& sweep = turns.sweeps[i];
    expect_columns(turns, sweep, range(0, 1024), 0);
    EXPECT_EQ(sweep.columns, 1024u);
    EXPECT_EQ(sweep.rings, 64);
    EXPECT_EQ(sweep.sequence, i);
    EXPECT_EQ(sweep.lost_packets, 0u);
    EXPECT_TRUE(sweep.gaps.empty());
    EXPECT_EQ(sweep.span.count(), 1023 * turns.column_ns());
    // Nothing delays these packets, so stamps are the device's.
    const int64_t begin = (65'534 + static_cast<int64_t>(i)) * 1024 * turns.column_ns();
    EXPECT_NEAR(static_cast<double>(sweep.stamp.ns() - kEpoch - 1'000'000'000 - begin), 0, 2e5);
  }
  EXPECT_EQ(turns.counters().packets, 4 * 64u);
  EXPECT_EQ(turns.counters().lost_network, 0u);
}

TEST(OusterTurnAssembler, CutsWhereItIsToldTo) {
  Turns turns({}, 270);  // 256 columns clockwise from the turn's beginning, which is behind
  turns.send_turn(1);
  turns.send_turn(2);
  turns.finish();
  ASSERT_EQ(turns.sweeps.size(), 3u);
  expect_columns(turns, turns.sweeps[0], range(768, 1024), 256);
  expect_columns(turns, turns.sweeps[1], range(0, 1024), 256);
  expect_columns(turns, turns.sweeps[2], range(0, 768), 256);
}

TEST(OusterTurnAssembler, SaysWhereATurnHasNoData) {
  Turns turns;
  turns.send(1, 512);
  turns.send(1, 528);
  turns.send(1, 560);
  turns.finish();
  ASSERT_EQ(turns.sweeps.size(), 1u);
  const Sweep& sweep = turns.sweeps[0];
  EXPECT_EQ(sweep.lost_packets, 1u);
  ASSERT_EQ(sweep.gaps.size(), 2u);
  // The turn begins behind; column 512 looks forward, and columns go on to the right.
  const double step = 2 * std::numbers::pi / 1024;
  EXPECT_NEAR(sweep.gaps[0].from, -32 * step, 1e-9);
  EXPECT_NEAR(sweep.gaps[0].to, -48 * step, 1e-9);
  EXPECT_NEAR(sweep.gaps[1].from, -64 * step, 1e-9);
  EXPECT_NEAR(sweep.gaps[1].to, 0, 1e-9);
  // Where the returns of a column are, within the beams' offsets of 3°.
  EXPECT_NEAR(std::atan2(sweep.y[0], sweep.x[0]), 0, 4 * std::numbers::pi / 180);
}

TEST(OusterTurnAssembler, CountsLostPacketsByColumn) {
  Turns turns;
  turns.send_turn(1);
  for (int first = 0; first < 1024; first += 16) {
    if (first != 32 && first != 48 && first != 1008) turns.send(2, first);
  }
  turns.send_turn(3, 16);
  turns.send_turn(8);  // four turns are missing
  turns.finish();
  EXPECT_EQ(turns.counters().lost_network, 2u + 2u + 4 * 64u);
  EXPECT_EQ(turns.counters().outages, 1u);
  EXPECT_EQ(turns.counters().lost_in_outages, 4 * 64u);
  ASSERT_EQ(turns.sweeps.size(), 4u);
  EXPECT_EQ(turns.sweeps[1].size(), 61u * 16 * 16);
  EXPECT_EQ(turns.sweeps[1].columns, 1024u);
  EXPECT_EQ(turns.sweeps[1].column.back(), 1007);
}

TEST(OusterTurnAssembler, DoesNotCountRefusedOrEmptyPacketsAsLost) {
  Turns turns;
  turns.send(1, 0);
  turns.assembler().note_refused();
  turns.send(1, 32);
  turns.send(1, 48, 0xFFFF);  // no valid column
  turns.send(1, 64);
  turns.send(1, 80, 0x00FF);
  turns.send(1, 96, 0xFF00);
  turns.send(1, 112);
  turns.finish();
  EXPECT_EQ(turns.counters().lost_network, 0u);
  EXPECT_EQ(turns.counters().packets, 7u);
  ASSERT_EQ(turns.sweeps.size(), 1u);
  EXPECT_EQ(turns.sweeps[0].size(), (16u + 16 + 16 + 8 + 8 + 16) * 16);
}

TEST(OusterTurnAssembler, PutsALatePacketBackAndDropsDuplicates) {
  Turns turns;
  for (const int first : {0, 32, 16, 48, 48, 0, 64}) turns.send(1, first);
  turns.finish();
  ASSERT_EQ(turns.sweeps.size(), 1u);
  expect_columns(turns, turns.sweeps[0], range(0, 80), 0);
  EXPECT_EQ(turns.counters().out_of_order, 1u);
  EXPECT_EQ(turns.counters().duplicates, 2u);
  EXPECT_EQ(turns.counters().lost_network, 0u);
}

TEST(OusterTurnAssembler, KnowsTheWindow) {
  Turns turns({.window = "[1, 256]"});
  for (const uint32_t turn : {5u, 6u, 7u}) turns.send_turn(turn, 1, 257);
  turns.finish();
  ASSERT_EQ(turns.sweeps.size(), 3u);
  for (const Sweep& sweep : turns.sweeps) {
    expect_columns(turns, sweep, range(0, 256), 1);
    EXPECT_EQ(sweep.columns, 256u);
    ASSERT_EQ(sweep.gaps.size(), 1u);
  }
  EXPECT_EQ(turns.counters().lost_network, 0u);
}

TEST(OusterTurnAssembler, KnowsAWindowThatIsNoMultipleOfAPacket) {
  Turns turns({.columns = "2048", .window = "[2014, 2036]", .mode = "2048x10"});
  for (const uint32_t turn : {5u, 6u, 8u}) {
    turns.send(turn, 2014);
    if (turn != 6) turns.send(turn, 2030, 0xFF80);
  }
  turns.finish();
  ASSERT_EQ(turns.sweeps.size(), 3u);
  expect_columns(turns, turns.sweeps[0], range(0, 23), 2014);
  expect_columns(turns, turns.sweeps[1], range(0, 16), 2014);
  EXPECT_EQ(turns.counters().lost_network, 3u);  // one of turn 6, both of turn 7
}

TEST(OusterTurnAssembler, KeepsAWindowThatWrapsInOneSweep) {
  for (const char* profile : {"LEGACY", "RNG15_RFL8_NIR8"}) {
    Turns turns({.profile = profile, .window = "[1000, 23]"});
    for (const uint32_t turn : {9u, 10u, 11u}) {
      turns.send(turn, 1000);
      turns.send(turn, 1016);  // its last eight columns are those of the next turn
      turns.send(turn + 1, 8);
    }
    turns.finish();
    ASSERT_EQ(turns.sweeps.size(), 3u);
    for (const Sweep& sweep : turns.sweeps) expect_columns(turns, sweep, range(0, 48), 1000);
    EXPECT_EQ(turns.counters().lost_network, 0u);
  }
}

TEST(OusterTurnAssembler, StartsAnewAfterARestart) {
  Turns turns;
  turns.send_turn(30'000);
  // Numbers of turns begin again; the clock, which PTP sets, goes on.
  for (int first = 0; first < 1024; first += 16) {
    turns.push({.frame_id = 3,
                .first_measurement_id = static_cast<uint16_t>(first),
                .device_ns = 1'000'000'000 + (int64_t{30'300} * 1024 + first) * turns.column_ns(),
                .column_ns = turns.column_ns(),
                .pixel = Turns::pixel});
  }
  turns.finish();
  ASSERT_EQ(turns.sweeps.size(), 2u);
  expect_columns(turns, turns.sweeps[1], range(0, 1024), 0);
  EXPECT_EQ(turns.counters().lost_network, 0u);
}

TEST(OusterTurnAssembler, EndsASweepThatLastsTooLong) {
  Turns turns;
  for (int i = 0; i < 64; ++i) {
    turns.push({.frame_id = 1,
                .first_measurement_id = static_cast<uint16_t>(16 * i),
                .device_ns = 1'000'000'000 + i * int64_t{16'000'000},
                .column_ns = 1'000'000,
                .pixel = Turns::pixel});
  }
  turns.finish();
  EXPECT_EQ(turns.sweeps.size(), 3u);  // of 0.4 s
}

TEST(OusterTurnAssembler, AllocatesNothingOnceItsSweepIsLargeEnough) {
  const Metadata metadata = parse_metadata(made_metadata({}), "").value();
  std::vector<std::vector<uint8_t>> payloads;
  for (uint16_t turn = 0; turn < 6; ++turn) {
    for (uint16_t first = 0; first < 1024; first = static_cast<uint16_t>(first + 16)) {
      payloads.push_back(made_packet(
          metadata, {.frame_id = turn,
                     .first_measurement_id = first,
                     .device_ns = 1'000'000'000 + (turn * int64_t{1024} + first) * 97'656}));
    }
  }
  ClockModelOptions clock;
  clock.modulo = Duration(0);
  lidar::PacketCounters counters;
  lidar::Losses losses(counters);
  TurnAssembler assembler(metadata, {.cut_azimuth = 180}, clock, counters, losses);
  Sweep sweep;
  size_t sweeps = 0;
  size_t before = 0;
  for (size_t i = 0; i < payloads.size(); ++i) {
    if (i == 3 * 64) before = allocation_count();
    assembler.push(
        {Stamp::from_ns(kEpoch + static_cast<int64_t>(i) * 1'562'500), 1, 7502, 7502, payloads[i]},
        {});
    while (assembler.pull(sweep)) ++sweeps;
  }
  EXPECT_EQ(allocation_count(), before);
  EXPECT_EQ(sweeps, 5u);
}

}  // namespace
}  // namespace infuse::ouster
