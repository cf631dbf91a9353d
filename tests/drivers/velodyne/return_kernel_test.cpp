#include "drivers/velodyne/return_kernel.hpp"
#include "drivers/velodyne/decoder.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/drivers/lidar/assemble.hpp"
#include "tests/drivers/velodyne/oracle.hpp"

namespace infuse::velodyne {
namespace {

template <class T>
bool same_bytes(const FieldVector<T>& a, const FieldVector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

TEST(ReturnKernel, AllInstructionSetsGiveTheSameBytes) {
  if (best_instruction_set() == InstructionSet::kBaseline)
    GTEST_SKIP() << "no vector unit to compare";
  for (const ModelInfo& info : models()) {
    for (const ReturnMode mode : {ReturnMode::kStrongest, ReturnMode::kDual}) {
      if (mode == ReturnMode::kDual && !info.has_dual_return) continue;
      const Scene scene = make_scene({.model = info.model,
                                      .mode = mode,
                                      .turns = 0.2,
                                      .calibration = built_in_calibration(info.model),
                                      .seed = 7});
      Decoder vector(
          {.model = &lidar_model(info.model), .instruction_set = best_instruction_set()});
      Decoder portable(
          {.model = &lidar_model(info.model), .instruction_set = InstructionSet::kBaseline});
      const std::vector<Sweep> a = assemble(vector, scene.packets);
      const std::vector<Sweep> b = assemble(portable, scene.packets);
      ASSERT_EQ(a.size(), b.size());
      for (size_t i = 0; i < a.size(); ++i) {
        ASSERT_GT(a[i].size(), 100U);
        EXPECT_TRUE(same_bytes(a[i].x, b[i].x)) << info.name;
        EXPECT_TRUE(same_bytes(a[i].y, b[i].y)) << info.name;
        EXPECT_TRUE(same_bytes(a[i].z, b[i].z)) << info.name;
        EXPECT_TRUE(same_bytes(a[i].range, b[i].range)) << info.name;
        EXPECT_TRUE(same_bytes(a[i].reflectivity, b[i].reflectivity)) << info.name;
        EXPECT_TRUE(same_bytes(a[i].ring, b[i].ring)) << info.name;
        EXPECT_TRUE(same_bytes(a[i].column, b[i].column)) << info.name;
        EXPECT_TRUE(same_bytes(a[i].time_offset_ns, b[i].time_offset_ns)) << info.name;
        EXPECT_TRUE(same_bytes(a[i].return_kind, b[i].return_kind)) << info.name;
      }
    }
  }
}

// Every pattern of returns and gaps among eight lasers.
TEST(ReturnKernel, KeepsExistingReturnsInOrder) {
  const BeamTable table(Model::kVlp16, built_in_calibration(Model::kVlp16), Duration(55'296));
  for (const InstructionSet instructions : {InstructionSet::kBaseline, best_instruction_set()}) {
    for (unsigned set = 0; set < 256; ++set) {
      std::array<uint8_t, 96> bytes{};
      std::vector<float> expected;
      for (size_t lane = 0; lane < 8; ++lane) {
        if ((set >> lane & 1) == 0) continue;
        for (size_t group = 0; group < 4; ++group) {
          bytes[24 * group + 3 * lane] = static_cast<uint8_t>(100 + 8 * group + lane);
        }
      }
      for (size_t slot = 0; slot < 32; ++slot) {
        if (bytes[3 * slot] != 0) expected.push_back(static_cast<float>(bytes[3 * slot]) * 0.002F);
      }
      Sweep sweep;
      sweep.resize(32 + lidar::kReturnSlack);
      const ReturnArrays arrays{sweep.x.data(),
                                sweep.y.data(),
                                sweep.z.data(),
                                sweep.range.data(),
                                sweep.reflectivity.data(),
                                sweep.ring.data(),
                                sweep.column.data(),
                                sweep.time_offset_ns.data(),
                                sweep.return_kind.data()};
      SequenceBlocks sequence;
      sequence.returns = bytes.data();
      const size_t size =
          return_kernel(instructions)(table, std::span(&sequence, 1), {}, arrays, 0);
      ASSERT_EQ(size, expected.size());
      for (size_t i = 0; i < size; ++i) ASSERT_EQ(sweep.range[i], expected[i]) << set;
    }
  }
}

}  // namespace
}  // namespace infuse::velodyne
