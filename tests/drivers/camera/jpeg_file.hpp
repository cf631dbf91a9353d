#pragma once

#include <gtest/gtest.h>
#include <turbojpeg.h>

#include <cstdint>
#include <vector>

namespace infuse::camera::testing {

/// A JPEG file of a smooth image: B rises to the right, G downwards, R is constant.
inline std::vector<uint8_t> make_jpeg(int width, int height, int subsampling) {
  std::vector<uint8_t> bgr;
  for (int r = 0; r < height; ++r) {
    for (int c = 0; c < width; ++c) {
      bgr.insert(bgr.end(), {static_cast<uint8_t>(2 * c), static_cast<uint8_t>(2 * r), 90});
    }
  }
  tjhandle encoder = tjInitCompress();
  unsigned char* data = nullptr;
  unsigned long size = 0;
  EXPECT_EQ(0, tjCompress2(encoder, bgr.data(), width, 0, height, TJPF_BGR, &data, &size,
                           subsampling, 98, 0));
  std::vector<uint8_t> file(data, data + size);
  tjFree(data);
  tjDestroy(encoder);
  return file;
}

}  // namespace infuse::camera::testing
