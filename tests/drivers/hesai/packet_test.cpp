#include "drivers/hesai/packet.hpp"

#include <gtest/gtest.h>

#include <random>

#include "drivers/lidar/azimuth.hpp"
#include "tests/drivers/hesai/made_packet.hpp"

namespace infuse::hesai {
namespace {

constexpr int64_t k20190725T031929 = 1'564'024'769;  // date -u -d '2019-07-25 03:19:29' +%s

tl::expected<Packet, PacketFault> parse(Model model, const std::vector<uint8_t>& bytes) {
  return parse_packet(model_info(model), bytes);
}

PacketFault fault_of(Model model, const std::vector<uint8_t>& bytes) {
  const auto packet = parse(model, bytes);
  EXPECT_FALSE(packet);
  return packet ? PacketFault::kSize : packet.error();
}

TEST(HesaiPacket, IsParsedForEachModelWithAndWithoutACounter) {
  for (const ModelInfo& info : models()) {
    for (const bool has_number : {false, true}) {
      std::vector<uint16_t> azimuths;
      for (int i = 0; i < info.blocks; ++i) azimuths.push_back(static_cast<uint16_t>(35'990 + i));
      const auto packet = parse(info.model, make_packet({.model = info.model,
                                                         .mode = ReturnMode::kLast,
                                                         .azimuths = azimuths,
                                                         .motor_speed = 599,
                                                         .microseconds = 654'321,
                                                         .number = 0x04030201,
                                                         .has_number = has_number}));
      ASSERT_TRUE(packet) << info.name;
      EXPECT_EQ(packet->mode, ReturnMode::kLast);
      EXPECT_EQ(packet->returns, 1);
      EXPECT_EQ(packet->sequences, info.blocks);
      EXPECT_EQ(packet->motor_speed, 599);
      EXPECT_EQ(packet->factory, 0x42);
      EXPECT_EQ(packet->distance_unit_mm, 4);
      EXPECT_EQ(packet->utc_ns, k20190725T031929 * 1'000'000'000 + 654'321'000) << info.name;
      EXPECT_EQ(packet->number.has_value(), has_number);
      EXPECT_EQ(packet->number.value_or(0x04030201), 0x04030201u);
      for (size_t i = 0; i < info.blocks; ++i) EXPECT_EQ(packet->azimuth[i], azimuths[i] % 36'000);
    }
  }
}

TEST(HesaiPacket, GroupsTheBlocksOfSeveralReturns) {
  const auto dual =
      parse(Model::kXt32,
            make_packet({.mode = ReturnMode::kLastStrongest, .azimuths = {10, 28, 46, 64}}));
  ASSERT_TRUE(dual);
  EXPECT_EQ(dual->returns, 2);
  EXPECT_EQ(dual->sequences, 4);
  EXPECT_EQ(dual->azimuth[3], 64);
  const auto triple = parse(Model::kXt32m, make_packet({.model = Model::kXt32m,
                                                        .mode = ReturnMode::kFirstLastStrongest,
                                                        .azimuths = {10, 28}}));
  ASSERT_TRUE(triple);
  EXPECT_EQ(triple->returns, 3);
  EXPECT_EQ(triple->sequences, 2);
}

TEST(HesaiPacket, OfAQt128IsFoundInEveryLength) {
  for (const bool has_safety : {false, true}) {
    for (const bool has_signature : {false, true}) {
      for (const bool has_number : {false, true}) {
        const auto packet = parse(Model::kQt128, make_packet({.model = Model::kQt128,
                                                              .azimuths = {40, 80},
                                                              .microseconds = 7,
                                                              .number = 11,
                                                              .has_number = has_number,
                                                              .mode_flag = 2,
                                                              .has_safety = has_safety,
                                                              .has_signature = has_signature}));
        ASSERT_TRUE(packet);
        EXPECT_EQ(packet->utc_ns, k20190725T031929 * 1'000'000'000 + 7'000);
        EXPECT_EQ(packet->number.value_or(11), 11u);
        EXPECT_EQ(packet->number.has_value(), has_number);
        EXPECT_EQ(packet->loop, 1);
      }
    }
  }
  EXPECT_EQ(parse(Model::kQt128, make_packet({.model = Model::kQt128, .mode_flag = 1}))->loop, 0);
  EXPECT_EQ(parse(Model::kQt128, make_packet({.model = Model::kQt128, .mode_flag = 0}))->loop, 1);
}

TEST(HesaiPacket, HasYearsSince1900AndSince2000AndSecondsSince1970) {
  const auto second = [](std::vector<uint8_t> date) {
    const auto packet = parse(Model::kXt32, make_packet({.date = std::move(date)}));
    return packet ? packet->utc_ns / 1'000'000'000 : -1;
  };
  EXPECT_EQ(second({119, 7, 25, 3, 19, 29}), k20190725T031929);
  EXPECT_EQ(second({19, 7, 25, 3, 19, 29}), k20190725T031929);
  EXPECT_EQ(second({0, 0, 0x5D, 0x39, 0x1F, 0xC1}), k20190725T031929);
  EXPECT_EQ(second({124, 2, 29, 23, 59, 60}), 1'709'251'200);
}

TEST(HesaiPacket, IsRefusedWithTheReason) {
  using enum PacketFault;
  const auto good = make_packet({});
  EXPECT_EQ(fault_of(Model::kXt32, {}), kSize);
  EXPECT_EQ(fault_of(Model::kXt32, {good.begin(), good.end() - 5}), kSize);
  EXPECT_EQ(fault_of(Model::kXt32, std::vector<uint8_t>(1500, 0xEE)), kSize);
  EXPECT_EQ(
      fault_of(Model::kQt128, make_packet({.model = Model::kQt128, .azimuths = {36'001, 36'001}})),
      kAzimuth);
  EXPECT_EQ(fault_of(Model::kXt32, make_packet({.date = {119, 2, 29, 0, 0, 0}})), kTime);
  EXPECT_EQ(fault_of(Model::kXt32, make_packet({.date = {119, 13, 1, 0, 0, 0}})), kTime);
  EXPECT_EQ(fault_of(Model::kXt32, make_packet({.date = {119, 1, 1, 24, 0, 0}})), kTime);
  EXPECT_EQ(fault_of(Model::kXt32, make_packet({.microseconds = 1'000'000})), kTime);
  EXPECT_EQ(fault_of(Model::kXt32, make_packet({.mode = static_cast<ReturnMode>(0x36)})),
            kReturnMode);
  EXPECT_EQ(fault_of(Model::kXt32, make_packet({.mode = ReturnMode::kFirstLastStrongest})),
            kReturnMode);
  EXPECT_EQ(fault_of(Model::kXt32, make_packet({.unit_mm = 0})), kHeader);
  for (const size_t at : {0u, 1u, 2u, 6u, 7u}) {
    auto wrong = good;
    wrong[at] ^= 0x55;
    EXPECT_EQ(fault_of(Model::kXt32, wrong), kHeader) << at;
  }
  for (const auto fault : {kSize, kHeader, kReturnMode, kAzimuth, kTime}) {
    EXPECT_STRNE(describe(fault), "");
  }
}

TEST(HesaiPacket, MarksSingleImpossibleAzimuths) {
  const auto single = parse(Model::kXt32, make_packet({.azimuths = {10, 36'001, 46, 64, 36'000}}));
  ASSERT_TRUE(single);
  EXPECT_EQ(single->azimuth[0], 10);
  EXPECT_EQ(single->azimuth[1], lidar::kNoAzimuth);
  EXPECT_EQ(single->azimuth[4], 0);
  auto bytes = make_packet({.mode = ReturnMode::kLastStrongest, .azimuths = {100, 118, 136, 154}});
  bytes[12 + 130] ^= 2;  // of the first firing's second block
  const auto dual = parse(Model::kXt32, bytes);
  ASSERT_TRUE(dual);
  EXPECT_EQ(dual->azimuth[0], lidar::kNoAzimuth);
  EXPECT_EQ(dual->azimuth[1], 118);
  bytes[12 + 3 * 130] ^= 2;
  EXPECT_EQ(fault_of(Model::kXt32, bytes), PacketFault::kAzimuth);
}

TEST(HesaiPacket, OfAnyLengthAndDamageIsParsedWithinItsBounds) {
  std::mt19937 random(1);
  for (const ModelInfo& info : models()) {
    const auto good = make_packet({.model = info.model});
    for (size_t size = 0; size <= good.size(); ++size) {
      const std::vector<uint8_t> exact(good.begin(), good.begin() + static_cast<ptrdiff_t>(size));
      static_cast<void>(recognise(exact));
      static_cast<void>(parse_packet(info, exact));
    }
    for (int i = 0; i < 2000; ++i) {
      auto bytes = good;
      for (int j = 0; j < 4; ++j) bytes[random() % bytes.size()] = static_cast<uint8_t>(random());
      const auto packet = parse_packet(info, bytes);
      if (!packet) continue;
      ASSERT_LE(size_t{packet->sequences} * packet->returns, info.blocks);
      for (size_t k = 0; k < packet->sequences; ++k) {
        ASSERT_TRUE(packet->azimuth[k] < 36'000 || packet->azimuth[k] == lidar::kNoAzimuth);
      }
    }
  }
}

TEST(HesaiPacket, NamesTheKindsOfReturnsInTheOrderOfBlocks) {
  using enum ReturnKind;
  EXPECT_EQ(return_kinds(Model::kXt32, ReturnMode::kLastStrongest)[0], kLast);
  EXPECT_EQ(return_kinds(Model::kXt32, ReturnMode::kLastStrongest)[1], kStrongest);
  EXPECT_EQ(return_kinds(Model::kQt64, ReturnMode::kFirstLast)[0], kFirst);
  EXPECT_EQ(return_kinds(Model::kQt64, ReturnMode::kFirstLast)[1], kLast);
  EXPECT_EQ(return_kinds(Model::kXt16, ReturnMode::kFirstLast)[0], kLast);
  EXPECT_EQ(return_kinds(Model::kXt16, ReturnMode::kFirstLast)[1], kFirst);
  EXPECT_EQ(return_kinds(Model::kQt128, ReturnMode::kStrongestSecond)[1], kSecondStrongest);
  EXPECT_EQ(return_kinds(Model::kXt32m, ReturnMode::kFirstLastStrongest)[2], kStrongest);
  EXPECT_EQ(return_kinds(Model::kPandar40p, ReturnMode::kFirst)[0], kFirst);
}

}  // namespace
}  // namespace infuse::hesai
