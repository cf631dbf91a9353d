#include "daemon/playback/list_images.hpp"

#include <algorithm>
#include <cctype>

#include "drivers/recording/drive.hpp"
#include "drivers/recording/times_csv.hpp"

namespace infuse::daemon {
namespace {

Result<ImageList> images_of_folder(const std::filesystem::path& folder) {
  ImageList out;
  std::error_code error;
  for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    std::string extension = it->path().extension().string();
    std::ranges::transform(extension, extension.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension == ".png" || extension == ".jpg" || extension == ".jpeg")
      out.files.push_back({it->path(), std::nullopt});
  }
  if (error) return fail(error.message(), folder.string(), "is the path right?");
  std::ranges::sort(out.files, {}, &ImageFile::path);
  return out;
}

Result<ImageList> images_of_drive(const std::filesystem::path& folder, const std::string& name) {
  const auto drive = recording::Drive::open(folder);
  if (!drive) return tl::unexpected(drive.error());
  const auto camera = find_camera(drive->description.rig, name, folder.string());
  if (!camera) return tl::unexpected(camera.error());
  const CameraMount& mount = drive->description.rig.cameras[*camera];
  const recording::CameraFiles& files = drive->description.cameras[*camera];
  const auto index = recording::index_images(drive->resolve(files.images), mount.stamp_delay);
  if (!index) return tl::unexpected(index.error());
  ImageList out{.camera = mount.name, .mosaic = files.mosaic, .rig = drive->description.rig};
  for (const auto& entry : index->entries) out.files.push_back({entry.path, entry.stamp});
  return out;
}

}  // namespace

Result<size_t> find_camera(const Rig& rig, const std::string& name, const std::string& where) {
  std::string names;
  for (size_t i = 0; i < rig.cameras.size(); ++i) {
    if (rig.cameras[i].name == name || (name.empty() && rig.cameras.size() == 1)) return i;
    names += (i == 0 ? "" : ", ") + rig.cameras[i].name;
  }
  if (rig.cameras.empty()) return fail("there is no camera", where);
  return fail(name.empty() ? "there are several cameras" : "there is no camera '" + name + "'",
              where, "choose one with --camera: " + names);
}

Result<ImageList> list_images(const std::filesystem::path& path, const std::string& camera) {
  std::error_code error;
  auto list = std::filesystem::exists(path / "drive.toml", error) ? images_of_drive(path, camera)
                                                                  : images_of_folder(path);
  if (list && list->files.empty())
    return fail("there are no images", path.string(), "PNG and JPEG are read");
  return list;
}

}  // namespace infuse::daemon
