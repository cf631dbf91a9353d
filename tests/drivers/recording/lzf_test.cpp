#include "drivers/recording/lzf.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <vector>

namespace infuse::recording {
namespace {

using Bytes = std::vector<uint8_t>;

std::string decompress(const Bytes& packed, size_t length) {
  std::string out(length, '?');
  const bool whole = decompress_lzf(packed, {reinterpret_cast<uint8_t*>(out.data()), length});
  return whole ? out : "refused";
}

TEST(Lzf, CopiesRunsAndWhatLiesBefore) {
  // "abc" as it is, six bytes from three before (which the copy itself makes), "X" as it is.
  const Bytes packed{2, 'a', 'b', 'c', 4 << 5, 2, 0, 'X'};
  EXPECT_EQ(decompress(packed, 10), "abcabcabcX");
}

TEST(Lzf, ALongCopyHasItsLengthInAByte) {
  // "z", then 7 + 2 + 200 bytes from one before.
  const Bytes packed{0, 'z', 7 << 5, 200, 0};
  EXPECT_EQ(decompress(packed, 210), std::string(210, 'z'));
}

TEST(Lzf, ReachesBackEightKibibytes) {
  Bytes packed;
  std::string expected;
  for (int k = 0; k < 8192; k += 32) {
    packed.push_back(31);
    for (int i = k; i < k + 32; ++i) {
      const auto byte = static_cast<uint8_t>((i * 7 + i / 256) & 255);
      packed.push_back(byte);
      expected.push_back(static_cast<char>(byte));
    }
  }
  packed.insert(packed.end(), {1 << 5 | 31, 255});  // three bytes from 8192 before
  expected += expected.substr(0, 3);
  EXPECT_EQ(decompress(packed, expected.size()), expected);
}

TEST(Lzf, RefusesWhatIsNotWhole) {
  EXPECT_EQ(decompress({2, 'a', 'b'}, 3), "refused");        // the run ends early
  EXPECT_EQ(decompress({0, 'a', 4 << 5}, 7), "refused");     // a copy from nowhere
  EXPECT_EQ(decompress({0, 'a', 7 << 5}, 10), "refused");    // a copy without its length
  EXPECT_EQ(decompress({0, 'a', 4 << 5, 1}, 7), "refused");  // from before the beginning
  EXPECT_EQ(decompress({2, 'a', 'b', 'c'}, 2), "refused");   // more than there is room for
  EXPECT_EQ(decompress({0, 'a', 4 << 5, 0}, 6), "refused");  // the same of a copy
  EXPECT_EQ(decompress({2, 'a', 'b', 'c'}, 4), "refused");   // less than was said
  EXPECT_EQ(decompress({0, 'a', 4 << 5, 0}, 7), "aaaaaaa");
}

}  // namespace
}  // namespace infuse::recording
