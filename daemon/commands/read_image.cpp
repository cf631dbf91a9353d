#include "daemon/commands/read_image.hpp"

#include <fstream>
#include <iterator>
#include <vector>

namespace infuse::daemon {

Result<CameraFrame> read_image(const std::filesystem::path& path,
                               const camera::ImageOptions& options) {
  std::ifstream stream(path, std::ios::binary);
  const std::vector<uint8_t> bytes{std::istreambuf_iterator<char>(stream), {}};
  if (!stream.good() && bytes.empty()) return fail("cannot be read", path.string());
  CameraFrame frame;
  camera::ImageOptions grey = options;
  grey.bayer.reset();
  if (auto decoded = camera::decode_image(bytes, grey, frame); !decoded) {
    return fail(decoded.error().what, path.string(), decoded.error().hint);
  }
  return frame;
}

}  // namespace infuse::daemon
