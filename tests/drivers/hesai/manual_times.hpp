#pragma once

#include <algorithm>
#include <optional>

#include "drivers/hesai/model.hpp"
#include "tests/drivers/hesai/made_packet.hpp"

// Firing times as the manuals and Hesai's correction files list them, in us: written down a second
// time, so that a slip in the product's tables shows.

namespace infuse::hesai {

/// A Pandar64 fires pairs of channels (from 1): the first sixteen pairs 1.304 us apart, the others
/// 1.968 us, the first 3.62 us before the block's end (manual, "Laser Firing Time").
inline constexpr int kPandar64Pairs[32][2]{
    {51, 61}, {45, 60}, {39, 57}, {9, 55},  {49, 63}, {43, 59}, {7, 56},  {53, 64},
    {47, 62}, {41, 58}, {6, 54},  {5, 48},  {4, 50},  {3, 52},  {2, 46},  {1, 44},
    {24, 33}, {27, 42}, {21, 36}, {15, 30}, {22, 37}, {16, 31}, {10, 25}, {19, 34},
    {13, 28}, {20, 35}, {14, 29}, {8, 23},  {17, 32}, {11, 26}, {18, 38}, {12, 40}};

/// Order in which a Pandar40P's channels (from 1) fire, backwards from its block's end, and their
/// time before it in us (manual, table II.4).
struct FiringOrder {
  int channel;
  double before_us;
};
inline constexpr FiringOrder kPandar40pOrder[]{
    {4, 3.62},   {40, 3.62},  {36, 4.92},  {28, 6.23},  {12, 8.19},  {16, 8.19},  {32, 9.5},
    {24, 11.47}, {29, 12.77}, {17, 14.74}, {3, 16.04},  {39, 16.04}, {35, 17.35}, {25, 18.65},
    {9, 20.62},  {13, 20.62}, {31, 21.92}, {21, 23.89}, {26, 25.19}, {14, 27.16}, {2, 28.47},
    {38, 28.47}, {34, 29.77}, {6, 31.74},  {22, 31.74}, {10, 33.71}, {30, 35.01}, {18, 36.98},
    {23, 38.95}, {11, 40.91}, {1, 42.22},  {37, 42.22}, {33, 43.52}, {5, 45.49},  {19, 45.49},
    {7, 47.46},  {27, 48.76}, {15, 50.73}, {20, 52.7},  {8, 54.67}};

/// Firing time correction file of a QT64: time of each channel after the moment of its block's
/// azimuth, which is 10 us after the block's time.
inline constexpr double kQt64File[64]{
    2.31,  4.37,   6.43,   8.49,   10.54,  12.6,   14.66,  16.71,  19.16,  21.22,  23.28,
    25.34, 27.39,  29.45,  31.5,   33.56,  36.61,  38.67,  40.73,  42.78,  44.84,  46.9,
    48.95, 51.01,  53.45,  55.52,  57.58,  59.63,  61.69,  63.74,  65.8,   67.86,  70.9,
    72.97, 75.02,  77.08,  79.14,  81.19,  83.25,  85.3,   87.75,  89.82,  91.87,  93.93,
    95.98, 98.04,  100.1,  102.15, 105.2,  107.26, 109.32, 111.38, 113.43, 115.49, 117.54,
    119.6, 122.05, 124.11, 126.17, 128.22, 130.28, 132.34, 134.39, 136.45};

/// Firing time file of a QT128: its two sequences; 0: the channel does not fire.
inline constexpr double kQt128Files[2][128]{
    {0,      0,      0,      0,      0,      0,      0,      0,      0,      0,      0,      0,
     0,      0,      0,      0,      0,      0,      0,      0,      0,      0,      0,      0,
     0,      0,      0,      0,      0,      0,      0,      0,      27.656, 53,     2.312,  78.344,
     81.512, 5.48,   56.168, 30.824, 33.992, 59.336, 8.648,  84.68,  87.848, 11.816, 62.504, 37.16,
     40.328, 65.672, 14.984, 91.016, 94.184, 18.152, 68.84,  43.496, 46.664, 72.008, 21.32,  97.352,
     100.52, 24.488, 75.176, 49.832, 1.456,  77.488, 26.8,   52.144, 55.312, 29.968, 80.656, 4.624,
     7.792,  83.824, 33.136, 58.48,  61.648, 36.304, 86.992, 10.96,  14.128, 90.16,  39.472, 64.816,
     67.984, 42.64,  93.328, 17.296, 20.464, 96.496, 45.808, 71.152, 74.32,  48.976, 99.664, 23.632,
     25.944, 51.288, 0.6,    76.632, 79.8,   3.768,  54.456, 29.112, 32.28,  57.624, 6.936,  82.968,
     86.136, 10.104, 60.792, 35.448, 38.616, 63.96,  13.272, 89.304, 92.472, 16.44,  67.128, 41.784,
     44.952, 70.296, 19.608, 95.64,  98.808, 22.776, 73.464, 48.12},
    {2.312,  78.344, 27.656, 53,     56.168, 30.824, 81.512, 5.48,   8.648,  84.68,  33.992, 59.336,
     62.504, 37.16,  87.848, 11.816, 14.984, 91.016, 40.328, 65.672, 68.84,  43.496, 94.184, 18.152,
     21.32,  97.352, 46.664, 72.008, 75.176, 49.832, 100.52, 24.488, 0,      0,      0,      0,
     0,      0,      0,      0,      0,      0,      0,      0,      0,      0,      0,      0,
     0,      0,      0,      0,      0,      0,      0,      0,      0,      0,      0,      0,
     0,      0,      0,      0,      0.6,    76.632, 25.944, 51.288, 54.456, 29.112, 79.8,   3.768,
     6.936,  82.968, 32.28,  57.624, 60.792, 35.448, 86.136, 10.104, 13.272, 89.304, 38.616, 63.96,
     67.128, 41.784, 92.472, 16.44,  19.608, 95.64,  44.952, 70.296, 73.464, 48.12,  98.808, 22.776,
     26.8,   52.144, 1.456,  77.488, 80.656, 4.624,  55.312, 29.968, 33.136, 58.48,  7.792,  83.824,
     86.992, 10.96,  61.648, 36.304, 39.472, 64.816, 14.128, 90.16,  93.328, 17.296, 67.984, 42.64,
     45.808, 71.152, 20.464, 96.496, 99.664, 23.632, 74.32,  48.976}};

/// Firing time of a channel (from 0) after its block's time; nothing if it does not fire.
inline std::optional<double> manual_channel_us(Model model, int channel, int loop) {
  switch (model) {
    case Model::kPandar40p:
      for (const auto& [fired, before_us] : kPandar40pOrder) {
        if (fired == channel + 1) return -before_us;
      }
      return std::nullopt;
    case Model::kPandar64:
      for (int pair = 0; pair < 32; ++pair) {
        const auto& [a, b] = kPandar64Pairs[pair];
        if (a == channel + 1 || b == channel + 1) {
          return -3.62 - 1.304 * std::min(pair, 15) - 1.968 * std::max(pair - 15, 0);
        }
      }
      return std::nullopt;
    case Model::kQt64:
      return 10 + kQt64File[channel];
    case Model::kQt128:
      if (kQt128Files[loop][channel] == 0) return std::nullopt;
      return kQt128Files[loop][channel];
    case Model::kXt16:
      return 0.368 + 3.024 * channel;
    case Model::kXt32:
      return 0.368 + 1.512 * channel;
    case Model::kXt32m:
      return 0.368 + 2.888 * (channel % 16);
  }
  return std::nullopt;
}

/// Time of firing `i` of `count` in a packet, after the packet's time.
inline double manual_block_us(Model model, int i, int count) {
  const int before_last = count - 1 - i;
  switch (model) {
    case Model::kPandar40p:
      return -28.58 - 55.56 * before_last;
    case Model::kPandar64:
      return -42.58 - 55.56 * before_last;
    case Model::kQt64:
      return 25.71 + 500.0 / 3 * i;
    case Model::kQt128:
      return 9 - 111.11 * before_last;
    default:
      return 5.632 - 50 * before_last;
  }
}

/// Moment of a block's azimuth after the block's time.
inline double manual_azimuth_us(Model model) {
  if (model == Model::kQt64) return 10;
  return lasers_of(model) <= 32 ? -5.632 : 0;
}

}  // namespace infuse::hesai
