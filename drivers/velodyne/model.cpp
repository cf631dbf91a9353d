#include "drivers/velodyne/model.hpp"

namespace infuse::velodyne {
namespace {

constexpr std::array<ModelInfo, 7> kModels{{
    {Model::kHdl32e, "HDL-32E", 32, 1, 1, 2, 0x21, Duration(46'080), false, true},
    {Model::kVlp16, "VLP-16", 16, 2, 1, 2, 0x22, Duration(55'296), false, true},
    {Model::kPuckHiRes, "Puck Hi-Res", 16, 2, 1, 2, 0x24, Duration(55'296), false, true},
    {Model::kVlp32c, "VLP-32C", 32, 1, 1, 4, 0x28, Duration(55'296), false, true},
    {Model::kHdl64eS2, "HDL-64E S2", 64, 1, 2, 2, 0, Duration(48'000), true, false},
    {Model::kHdl64eS3, "HDL-64E S3", 64, 1, 2, 2, 0, Duration(57'600), true, true},
    {Model::kVls128, "VLS-128", 128, 1, 4, 4, 0xA1, Duration(55'280), false, true},
}};

/// Firing time of laser `j` of an HDL-64E bank: four lasers per group, unevenly spaced.
int32_t hdl64e_time(size_t j, int32_t group_ns, const std::array<int32_t, 4>& in_group_ns) {
  return static_cast<int32_t>(j / 4) * group_ns + in_group_ns[j % 4];
}

/// Firing time of laser `j` of a VLS-128: groups of eight, one slot each, one dead slot after the
/// eighth group and three at the end, so that a cycle has twenty slots.
int32_t vls128_time(size_t j, Duration cycle) {
  const auto group = static_cast<int64_t>(j / 8);
  const int64_t slot = group + (group >= 8 ? 1 : 0);
  return static_cast<int32_t>((slot * cycle.count() + 10) / 20);
}

}  // namespace

size_t ModelInfo::sequences_per_packet(bool dual_return) const {
  if (banks == 4) return dual_return ? 1 : 3;  // dual: the last four blocks stay empty
  return 12u / banks / (dual_return ? 2 : 1);
}

const ModelInfo& model_info(Model model) { return kModels[static_cast<size_t>(model)]; }

std::span<const ModelInfo> models() { return kModels; }

Duration packet_period(const ModelInfo& info, Duration cycle, bool dual_return) {
  return sequence_period(info, cycle) *
         static_cast<int64_t>(info.sequences_per_packet(dual_return));
}

std::array<int32_t, kMaxSlots> firing_times(const ModelInfo& info, Duration cycle) {
  std::array<int32_t, kMaxSlots> times{};
  for (size_t slot = 0; slot < info.slots(); ++slot) {
    const auto j = static_cast<int32_t>(slot % info.lasers);
    const auto firing = static_cast<int32_t>(slot / info.lasers);
    switch (info.model) {
      case Model::kHdl32e:
        times[slot] = 1'152 * j;
        break;
      case Model::kVlp16:
      case Model::kPuckHiRes:
        times[slot] = 2'304 * j + static_cast<int32_t>(cycle.count()) * firing;
        break;
      case Model::kVlp32c:
        times[slot] = 2'304 * (j / 2);
        break;
      case Model::kHdl64eS2:
        times[slot] = hdl64e_time(slot % kSlotsPerBlock, 6'000, {0, 1'260, 2'460, 3'660});
        break;
      case Model::kHdl64eS3:
        times[slot] = hdl64e_time(slot % kSlotsPerBlock, 7'200, {0, 1'300, 2'500, 3'700});
        break;
      case Model::kVls128:
        times[slot] = vls128_time(slot, cycle);
        break;
    }
  }
  return times;
}

}  // namespace infuse::velodyne
