#include "daemon/tools/places/image_files.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>

#include "daemon/command_line/progress_line.hpp"
#include "daemon/playback/list_images.hpp"
#include "daemon/playback/read_image.hpp"

namespace infuse::daemon {
namespace {

constexpr double kMaxAspectChange = 0.03;  // of the shape, between images that are compared

}  // namespace

Result<ImageFiles> read_image_files(const std::string& path, const std::string& camera,
                                    std::optional<double> aspect,
                                    const std::function<void(const CameraFrame&)>& on_image) {
  const auto list = list_images(path, camera);
  if (!list) return tl::unexpected(list.error());
  const std::vector<ImageFile>& files = list->files;
  ImageFiles out;
  ProgressLine line;
  for (const ImageFile& file : files) {
    const auto frame = read_image(file.path, {.grey = true});
    if (!frame) return tl::unexpected(frame.error());
    const double own = static_cast<double>(frame->width) / frame->height;
    if (!aspect) aspect = own;
    if (std::abs(own / *aspect - 1) > kMaxAspectChange) {
      return fail(fmt::format("the image differs in size from those before: {} x {} pixels",
                              frame->width, frame->height),
                  file.path.string(), "images of one camera can be compared");
    }
    on_image(*frame);
    out.list.names.push_back(file.path.filename().string());
    if (file.stamp) out.list.stamps.push_back(*file.stamp);
    line.show(static_cast<double>(out.list.names.size()) / static_cast<double>(files.size()),
              fmt::format("{} of {} images", out.list.names.size(), files.size()));
  }
  line.clear();
  out.aspect = *aspect;
  return out;
}

}  // namespace infuse::daemon
