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

TEST(Lzf, CopiesLiteralsAndBackReferences) {
  // Literal "abc", six bytes from distance three (overlapping itself), literal "X".
  const Bytes packed{2, 'a', 'b', 'c', 4 << 5, 2, 0, 'X'};
  EXPECT_EQ(decompress(packed, 10), "abcabcabcX");
}

TEST(Lzf, LongBackReferencesHaveALengthByte) {
  // "z", then 7 + 2 + 200 bytes from distance one.
  const Bytes packed{0, 'z', 7 << 5, 200, 0};
  EXPECT_EQ(decompress(packed, 210), std::string(210, 'z'));
}

TEST(Lzf, BackReferencesReachEightKibibytes) {
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
  packed.insert(packed.end(), {1 << 5 | 31, 255});  // three bytes from distance 8192
  expected += expected.substr(0, 3);
  EXPECT_EQ(decompress(packed, expected.size()), expected);
}

TEST(Lzf, RejectsInvalidData) {
  EXPECT_EQ(decompress({2, 'a', 'b'}, 3), "refused");        // literal run too short
  EXPECT_EQ(decompress({0, 'a', 4 << 5}, 7), "refused");     // missing distance byte
  EXPECT_EQ(decompress({0, 'a', 7 << 5}, 10), "refused");    // missing length byte
  EXPECT_EQ(decompress({0, 'a', 4 << 5, 1}, 7), "refused");  // distance before the beginning
  EXPECT_EQ(decompress({2, 'a', 'b', 'c'}, 2), "refused");   // literal run too long for the output
  EXPECT_EQ(decompress({0, 'a', 4 << 5, 0}, 6),
            "refused");  // back reference too long for the output
  EXPECT_EQ(decompress({2, 'a', 'b', 'c'}, 4), "refused");  // output not filled
  EXPECT_EQ(decompress({0, 'a', 4 << 5, 0}, 7), "aaaaaaa");
}

}  // namespace
}  // namespace infuse::recording
