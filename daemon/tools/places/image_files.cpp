#include "daemon/tools/places/image_files.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "daemon/command_line/progress_line.hpp"
#include "daemon/playback/read_image.hpp"
#include "drivers/recording/drive_toml.hpp"
#include "drivers/recording/times_csv.hpp"

namespace infuse::daemon {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxAspectChange = 0.03;  // of the shape, between images that are compared

struct ImageFile {
  fs::path path;
  std::optional<Stamp> stamp;
};

Result<std::vector<ImageFile>> images_of_folder(const fs::path& folder) {
  std::vector<ImageFile> out;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::string extension = it->path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension == ".png" || extension == ".jpg" || extension == ".jpeg")
      out.push_back({it->path(), std::nullopt});
  }
  if (error) return fail(error.message(), folder.string(), "is the path right?");
  std::sort(out.begin(), out.end(),
            [](const ImageFile& a, const ImageFile& b) { return a.path < b.path; });
  return out;
}

Result<std::vector<ImageFile>> images_of_drive(const std::string& path, const std::string& name) {
  const auto drive = recording::Drive::open(path);
  if (!drive) return tl::unexpected(drive.error());
  const Rig& rig = drive->description.rig;
  std::string names;
  for (size_t i = 0; i < rig.cameras.size(); ++i) {
    names += (i == 0 ? "" : ", ") + rig.cameras[i].name;
    if (rig.cameras[i].name != name && !(name.empty() && rig.cameras.size() == 1)) continue;
    const auto index = recording::index_images(drive->resolve(drive->description.cameras[i].images),
                                               rig.cameras[i].stamp_delay);
    if (!index) return tl::unexpected(index.error());
    std::vector<ImageFile> out;
    for (const auto& entry : index->entries) out.push_back({entry.path, entry.stamp});
    return out;
  }
  if (rig.cameras.empty()) return fail("the drive has no camera", path);
  return fail(
      name.empty() ? "the drive has several cameras" : "the drive has no camera '" + name + "'",
      path, "choose one with --camera: " + names);
}

}  // namespace

Result<ImageFiles> read_image_files(const std::string& path, const std::string& camera,
                                    std::optional<double> aspect,
                                    const std::function<void(const CameraFrame&)>& on_image) {
  const bool drive = fs::exists(fs::path(path) / "drive.toml");
  const auto files = drive ? images_of_drive(path, camera) : images_of_folder(path);
  if (!files) return tl::unexpected(files.error());
  if (files->empty()) return fail("there are no images", path, "PNG and JPEG are read");
  ImageFiles out;
  ProgressLine line;
  for (const ImageFile& file : *files) {
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
    line.show(static_cast<double>(out.list.names.size()) / static_cast<double>(files->size()),
              fmt::format("{} of {} images", out.list.names.size(), files->size()));
  }
  line.clear();
  out.aspect = *aspect;
  return out;
}

}  // namespace infuse::daemon
