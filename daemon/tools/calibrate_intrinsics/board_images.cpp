#include "daemon/tools/calibrate_intrinsics/board_images.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <map>
#include <utility>

#include "daemon/command_line/progress_line.hpp"
#include "daemon/playback/list_images.hpp"
#include "daemon/playback/read_image.hpp"

namespace infuse::daemon {
namespace {

constexpr Duration kMinInterval = std::chrono::milliseconds(500);  // of a drive's images

using ImageSize = std::pair<int, int>;

/// A board in an image.
struct SizedView {
  std::string name;
  target::Corners corners;
  ImageSize size;
};

/// Searches the images of one drive or folder.
void search_images(const ImageList& list, const target::Board& board, std::vector<SizedView>& views,
                   BoardImages& out) {
  ProgressLine line;
  std::optional<Stamp> last;
  for (size_t k = 0; k < list.files.size(); ++k) {
    const ImageFile& file = list.files[k];
    if (last && file.stamp && distance_between(*file.stamp, *last) < kMinInterval) continue;
    last = file.stamp;
    line.show(
        static_cast<double>(k) / static_cast<double>(list.files.size()),
        fmt::format("image {} of {}, {} with a board", k + 1, list.files.size(), views.size()));
    ++out.images;
    const std::string name = (file.path.parent_path().filename() / file.path.filename()).string();
    const auto image = read_grey_image(file.path, list.mosaic);
    if (!image) {
      out.skipped.push_back(image.error().message());
      continue;
    }
    auto boards = target::find_boards(*image, board, 1);
    if (boards.empty()) {
      out.skipped.push_back(name + ": no board in the image");
    } else {
      views.push_back({name, std::move(boards.front()), {image->width, image->height}});
    }
  }
}

/// Keeps the views in images of that size that most of them have.
void keep_one_size(std::vector<SizedView>& views, BoardImages& out) {
  std::map<ImageSize, size_t> counts;
  for (const SizedView& view : views) ++counts[view.size];
  if (counts.empty()) return;
  const ImageSize size =
      std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; })->first;
  std::tie(out.width, out.height) = size;
  for (SizedView& view : views) {
    if (view.size != size) {
      out.skipped.push_back(fmt::format("{}: {} × {} pixels, most images have {} × {}", view.name,
                                        view.size.first, view.size.second, out.width, out.height));
      continue;
    }
    out.names.push_back(std::move(view.name));
    out.views.push_back(std::move(view.corners));
  }
}

}  // namespace

Result<BoardImages> find_board_images(const std::vector<std::string>& inputs,
                                      const std::string& camera, const target::Board& board) {
  BoardImages out;
  std::vector<SizedView> views;
  for (const std::string& input : inputs) {
    const auto list = list_images(input, camera);
    if (!list) return tl::unexpected(list.error());
    if (out.rig.cameras.empty()) {
      out.rig = list->rig;
      out.camera = list->camera;
    }
    search_images(*list, board, views, out);
  }
  keep_one_size(views, out);
  return out;
}

}  // namespace infuse::daemon
