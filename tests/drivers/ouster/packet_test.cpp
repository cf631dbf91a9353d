#include "drivers/ouster/packet.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "tests/drivers/ouster/made_metadata.hpp"
#include "tests/drivers/ouster/made_packet.hpp"

namespace infuse::ouster {
namespace {

Metadata sensor(Profile profile, size_t beams = 64) {
  MadeMetadata values;
  values.beams = beams;
  values.profile = profile_info(profile).name;
  return parse_metadata(made_metadata(values), "").value();
}

class OusterPacket : public testing::TestWithParam<ProfileInfo> {};

TEST_P(OusterPacket, HasTheSizesOfTheManual) {
  const std::map<std::pair<Profile, size_t>, size_t> sizes{
      {{Profile::kLegacy, 16}, 3392},          {{Profile::kLegacy, 32}, 6464},
      {{Profile::kLegacy, 64}, 12'608},        {{Profile::kLegacy, 128}, 24'896},
      {{Profile::kRng19, 16}, 3328},           {{Profile::kRng19, 32}, 6400},
      {{Profile::kRng19, 64}, 12'544},         {{Profile::kRng19, 128}, 24'832},
      {{Profile::kRng19Dual, 16}, 4352},       {{Profile::kRng19Dual, 32}, 8448},
      {{Profile::kRng19Dual, 64}, 16'640},     {{Profile::kRng19Dual, 128}, 33'024},
      {{Profile::kRng15, 16}, 1280},           {{Profile::kRng15, 32}, 2304},
      {{Profile::kRng15, 64}, 4352},           {{Profile::kRng15, 128}, 8448},
      {{Profile::kFusaDual, 64}, 8448},        {{Profile::kFusaDual, 128}, 16'640},
      {{Profile::kRng15Dual, 128}, 16'640},    {{Profile::kRng15Zone, 128}, 16'640},
      {{Profile::kRng15Window, 128}, 8448},    {{Profile::kRng19Zone, 128}, 24'832},
      {{Profile::kRng19ZoneDual, 128}, 33'024}};
  for (const auto& [key, bytes] : sizes) {
    if (key.first != GetParam().profile) continue;
    EXPECT_EQ(PacketLayout(sensor(key.first, key.second)).packet_bytes(), bytes) << key.second;
  }
}

TEST_P(OusterPacket, ReadsHeadsAndFields) {
  const Metadata metadata = sensor(GetParam().profile);
  const auto payload = made_packet(
      metadata, {.frame_id = 1259,
                 .first_measurement_id = 1008,
                 .device_ns = 765'697'050'000,
                 .invalid_columns = 0b100,
                 .pixel = [](uint16_t id, size_t beam) {
                   const auto i = static_cast<uint32_t>(beam);
                   return MadePixel{8 * (id + i), 16 * (id + i), static_cast<uint8_t>(i),
                                    static_cast<uint8_t>(2 * i), static_cast<uint16_t>(i)};
                 }});
  const PacketLayout layout(metadata);
  const auto packet = parse_packet(layout, payload);
  ASSERT_TRUE(packet) << describe(packet.error());
  EXPECT_EQ(packet->frame_id, 1259u);
  const bool legacy = GetParam().profile == Profile::kLegacy;
  EXPECT_EQ(packet->initialization_id, legacy ? 0u : 5'431'293u);
  EXPECT_EQ(packet->serial_number, legacy ? 0u : 992'110'000'123u);
  ASSERT_EQ(packet->count, 16);
  for (uint32_t i = 0; i < packet->count; ++i) {
    const Column& column = packet->columns[i];
    EXPECT_EQ(column.measurement_id, 1008 + i);
    EXPECT_EQ(column.device_ns, 765'697'050'000 + 97'656 * static_cast<int64_t>(i));
    EXPECT_EQ(column.valid, i != 2);
    for (uint32_t beam = 0; beam < 64; ++beam) {
      const uint8_t* pixel = column.pixels + beam * GetParam().pixel_bytes;
      ASSERT_EQ(GetParam().echo[0].range.read(pixel), 8 * (1008 + i + beam));
      ASSERT_EQ(GetParam().echo[0].reflectivity.read(pixel), beam);
      if (GetParam().echoes == 2) {
        ASSERT_EQ(GetParam().echo[1].range.read(pixel), 16 * (1008 + i + beam));
        ASSERT_EQ(GetParam().echo[1].reflectivity.read(pixel), 2 * beam);
      }
      if (GetParam().near_infrared.bits == 0) continue;
      ASSERT_EQ(GetParam().near_infrared.read(pixel), beam * GetParam().near_infrared.unit);
    }
  }
}

TEST_P(OusterPacket, RefusesOtherBytes) {
  const Metadata metadata = sensor(GetParam().profile);
  const PacketLayout layout(metadata);
  const auto fault = [&](const std::vector<uint8_t>& payload) {
    const auto packet = parse_packet(layout, payload);
    return packet ? std::optional<PacketFault>() : packet.error();
  };
  auto payload = made_packet(metadata, {});
  ASSERT_EQ(fault(payload), std::nullopt);
  payload.pop_back();
  EXPECT_EQ(fault(payload), PacketFault::kSize);
  EXPECT_EQ(fault({}), PacketFault::kSize);
  EXPECT_EQ(fault(made_packet(metadata, {.column_ns = 0})), PacketFault::kColumns);
  EXPECT_EQ(fault(made_packet(metadata, {.column_ns = -1})), PacketFault::kColumns);
  EXPECT_EQ(fault(made_packet(metadata, {.column_ns = 1'000'000'000})), PacketFault::kColumns);
  EXPECT_EQ(fault(made_packet(metadata, {.device_ns = INT64_MAX - 10'000'000})),
            PacketFault::kColumns);
  if (GetParam().profile != Profile::kLegacy) {
    EXPECT_EQ(fault(made_packet(metadata, {.type = 2})), PacketFault::kType);
  }
  // A measurement id beyond the turn.
  payload = made_packet(metadata, {});
  payload[GetParam().packet_header_bytes() + 9] = 4;
  EXPECT_EQ(fault(payload), PacketFault::kColumns);
  // The same in a column that is not valid.
  payload = made_packet(metadata, {.invalid_columns = 1});
  payload[GetParam().packet_header_bytes() + 9] = 4;
  EXPECT_EQ(fault(payload), std::nullopt);
}

TEST_P(OusterPacket, IsRecognisedWithoutMetadata) {
  for (const size_t beams : {16, 32, 64, 128}) {
    EXPECT_TRUE(read_head(made_packet(sensor(GetParam().profile, beams), {}))) << beams;
  }
  std::mt19937 random(1);
  for (const size_t size : {48, 1206, 1248, 3392, 6464, 12'608, 24'832, 33'024, 0}) {
    std::vector<uint8_t> noise(size);
    for (uint8_t& byte : noise) byte = static_cast<uint8_t>(random());
    EXPECT_FALSE(read_head(noise)) << size;
    EXPECT_FALSE(read_head(std::vector<uint8_t>(size))) << size;
  }
}

INSTANTIATE_TEST_SUITE_P(Profiles, OusterPacket, testing::ValuesIn(kProfiles),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(OusterPacket, TakesTheFrameIdOfTheFirstValidColumn) {
  const Metadata metadata = sensor(Profile::kLegacy);
  auto payload = made_packet(metadata, {.frame_id = 7, .invalid_columns = 1});
  payload[10] = 99;
  EXPECT_EQ(parse_packet(PacketLayout(metadata), payload)->frame_id, 7u);
}

/// Firmware from 3.2 on states the layout of the header apart from that of the pixels.
TEST(OusterPacket, HasTheHeaderThatTheMetadataStates) {
  Metadata metadata = sensor(Profile::kRng15Dual);
  EXPECT_FALSE(metadata.fusa_header);
  metadata.fusa_header = true;
  const auto payload = made_packet(metadata, {.frame_id = 0x12345678});
  const auto packet = parse_packet(PacketLayout(metadata), payload);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->frame_id, 0x12345678u);
  EXPECT_EQ(packet->serial_number, 992'110'000'123u);
  const auto head = read_head(payload);
  ASSERT_TRUE(head);
  EXPECT_EQ(head->serial_number, 992'110'000'123u);
}

}  // namespace
}  // namespace infuse::ouster
