#include "drivers/hesai/firing_times.hpp"

#include <algorithm>
#include <span>

namespace infuse::hesai {
namespace {

// Time of each channel after its block's end (Pandar40P, Pandar64; both fire before it) or start
// (QT64), ns: the manuals' appendix "Laser Firing Time".
constexpr std::array<int32_t, 40> kPandar40pTimes{
    -42220, -28470, -16040, -3620,  -45490, -31740, -47460, -54670, -20620, -33710,
    -40910, -8190,  -20620, -27160, -50730, -8190,  -14740, -36980, -45490, -52700,
    -23890, -31740, -38950, -11470, -18650, -25190, -48760, -6230,  -12770, -35010,
    -21920, -9500,  -43520, -29770, -17350, -4920,  -42220, -28470, -16040, -3620};

constexpr std::array<int32_t, 64> kPandar64Times{
    -23180, -21876, -20572, -19268, -17964, -16660, -11444, -46796, -7532,  -36956, -50732,
    -54668, -40892, -44828, -31052, -34988, -48764, -52700, -38924, -42860, -29084, -33020,
    -46796, -25148, -36956, -50732, -27116, -40892, -44828, -31052, -34988, -48764, -25148,
    -38924, -42860, -29084, -33020, -52700, -6228,  -54668, -15356, -27116, -10140, -23180,
    -4924,  -21876, -14052, -17964, -8836,  -19268, -3620,  -20572, -12748, -16660, -7532,
    -11444, -6228,  -15356, -10140, -4924,  -3620,  -14052, -8836,  -12748};

constexpr std::array<int32_t, 64> kQt64Times{
    12310,  14370,  16430,  18490,  20540,  22600,  24660,  26710,  29160,  31220,  33280,
    35340,  37390,  39450,  41500,  43560,  46610,  48670,  50730,  52780,  54840,  56900,
    58950,  61010,  63450,  65520,  67580,  69630,  71690,  73740,  75800,  77860,  80900,
    82970,  85020,  87080,  89140,  91190,  93250,  95300,  97750,  99820,  101870, 103930,
    105980, 108040, 110100, 112150, 115200, 117260, 119320, 121380, 123430, 125490, 127540,
    129600, 132050, 134110, 136170, 138220, 140280, 142340, 144390, 146450};

/// Time of a QT128's channel in one of its two firing sequences; nothing if it does not fire there:
/// QT128C2X manual, appendix "Absolute Time of Point Cloud Data". Three of the four banks of 32
/// channels fire together, 0.856 us apart; in each bank eight channels make a group of 6.336 us.
std::optional<int32_t> qt128_time(size_t channel, size_t loop) {
  constexpr std::array<int32_t, 8> kGroup{27'656, 53'000, 2'312,  78'344,
                                          81'512, 5'480,  56'168, 30'824};
  constexpr int32_t kGroupNs = 6'336;
  constexpr int32_t kBankNs = 856;
  constexpr int kSilent = -1;
  struct Bank {
    int place;    // how many times 0.856 us before the first bank
    size_t swap;  // 2: the pairs of each four channels change places
  };
  constexpr std::array<std::array<Bank, 4>, 2> kBanks{
      {{{{kSilent, 0}, {0, 0}, {1, 2}, {2, 0}}}, {{{0, 2}, {kSilent, 0}, {2, 2}, {1, 0}}}}};
  const Bank& bank = kBanks[loop][channel / 32];
  if (bank.place == kSilent) return std::nullopt;
  const size_t in_bank = channel % 32;
  return kGroup[(in_bank ^ bank.swap) % 8] + kGroupNs * static_cast<int32_t>(in_bank / 8) -
         kBankNs * bank.place;
}

std::optional<int32_t> channel_time(Model model, size_t channel, size_t loop) {
  const auto number = static_cast<int32_t>(channel);
  switch (model) {
    case Model::kPandar40p:
      return kPandar40pTimes[channel];
    case Model::kPandar64:
      return kPandar64Times[channel];
    case Model::kQt64:
      return kQt64Times[channel];
    case Model::kQt128:
      return qt128_time(channel, loop);
    case Model::kXt16:
      return 368 + 3'024 * number;
    case Model::kXt32:
      return 368 + 1'512 * number;
    case Model::kXt32m:
      return 368 + 2'888 * (number % 16);
  }
  return std::nullopt;
}

/// Time from a block's time to the moment of its azimuth.
int32_t azimuth_time(Model model) {
  switch (model) {
    case Model::kQt64:
      return 10'000;
    case Model::kXt16:
    case Model::kXt32:
    case Model::kXt32m:
      return -5'632;
    case Model::kPandar40p:
    case Model::kPandar64:
    case Model::kQt128:
      break;
  }
  return 0;
}

}  // namespace

size_t number_of_loops(Model model) { return model == Model::kQt128 ? 2 : 1; }

FiringTimes firing_times(Model model, size_t loop) {
  FiringTimes times;
  times.azimuth_ns = azimuth_time(model);
  const size_t lasers = model_info(model).lasers;
  std::optional<int32_t> first;
  for (size_t channel = 0; channel < lasers; ++channel) {
    const auto time = channel_time(model, channel, loop);
    if (!time) continue;
    times.channel_ns[channel] = *time;
    times.last_ns = first ? std::max(times.last_ns, *time) : *time;
    first = std::min(first.value_or(*time), *time);
  }
  times.first_ns = first.value_or(0);
  for (size_t channel = 0; channel < lasers; ++channel) {
    if (!channel_time(model, channel, loop)) times.channel_ns[channel] = times.first_ns;
  }
  return times;
}

int64_t block_time_ns(Model model, const Packet& packet, size_t sequence) {
  const int64_t to_last =
      static_cast<int64_t>(packet.sequences) - 1 - static_cast<int64_t>(sequence);
  switch (model) {
    case Model::kPandar40p:
      return -28'580 - 55'560 * to_last;
    case Model::kPandar64:
      return -42'580 - 55'560 * to_last;
    case Model::kQt64:
      return 25'710 + 500'000 * static_cast<int64_t>(sequence) / 3;
    case Model::kQt128:
      return 9'000 - 111'110 * to_last;
    case Model::kXt16:
    case Model::kXt32:
    case Model::kXt32m:
      return 5'632 - 50'000 * to_last;
  }
  return 0;
}

}  // namespace infuse::hesai
