#include "daemon/streetmap/street_map_file.hpp"

#include <sys/stat.h>

#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <map>
#include <memory>
#include <span>
#include <string>

#include "daemon/streetmap/street_plan_from_osm.hpp"
#include "drivers/camera/image_decoder.hpp"
#include "drivers/osm/openstreetmap.hpp"
#include "drivers/recording/mapped_file.hpp"
#include "drivers/text/checksum.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

Result<GeneratedStreetMap> make_from_image(const std::filesystem::path& input,
                                           const streetmap::ImageMapOptions& options) {
  const auto file = recording::MappedFile::open(input);
  if (!file) return tl::unexpected(file.error());
  const auto bytes = file->bytes();
  CameraFrame grey;
  const auto decoded = camera::decode_image(
      {reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, {.grey = true}, grey);
  if (!decoded) return fail(decoded.error().what, input.string(), decoded.error().hint);
  auto made = streetmap::make_map_from_image(grey, options, "image " + input.filename().string());
  if (!made) return fail(made.error().what, input.string(), made.error().hint);
  return GeneratedStreetMap{std::move(*made), {}};
}

/// Keeps the first few warnings of a kind; the last of them counts the others. Texts that differ in
/// numbers only are of one kind.
std::vector<Error> group_warnings(const std::vector<Error>& warnings) {
  constexpr size_t kOfAKind = 3;
  struct Group {
    size_t count = 0;
    size_t last = 0;  // in the result
  };
  std::map<std::string, Group> groups;
  std::vector<Error> grouped;
  for (const Error& warning : warnings) {
    std::string kind = warning.where + "|" + warning.what;
    std::erase_if(kind, [](unsigned char c) { return std::isdigit(c) != 0; });
    Group& group = groups[kind];
    if (++group.count > kOfAKind) continue;
    group.last = grouped.size();
    grouped.push_back(warning);
  }
  for (const auto& [kind, group] : groups) {
    if (group.count <= kOfAKind) continue;
    grouped[group.last].what += "; " + std::to_string(group.count - kOfAKind) + " more like this";
  }
  return grouped;
}

Result<GeneratedStreetMap> make_from_openstreetmap(const std::filesystem::path& input,
                                                   const StreetMapOptions& options) {
  const auto show = [&](std::optional<double> share, const char* what) {
    if (options.progress) options.progress(share, what);
  };
  show({}, "reads");
  auto map = osm::read_openstreetmap(input);
  if (!map) return tl::unexpected(map.error());
  OsmStreetPlan planned = build_street_plan(*map, options.clip);
  *map = {};  // frees the memory before the raster needs it
  if (planned.carriageway_count == 0) {
    return options.clip ? fail("has no drivable road within --clip", input.string(),
                               "give WEST,SOUTH,EAST,NORTH in degrees")
                        : fail("has no drivable road", input.string(),
                               "no way of the map has a highway tag of a known class");
  }
  auto made = streetmap::rasterise(
      planned.plan, options.raster,
      "OpenStreetMap " + input.filename().string() + ", © OpenStreetMap contributors, ODbL",
      [&](double share) { show(share, "draws"); });
  if (!made) return fail(made.error().what, input.string(), made.error().hint);
  return GeneratedStreetMap{std::move(*made), group_warnings(planned.warnings)};
}

}  // namespace

Result<StreetMapFile> open_street_map_file(const std::filesystem::path& path) {
  // At a replacement two maps are in memory; the service has 2 GB (systemd/infused.service).
  constexpr size_t kMaxBytes = size_t{512} << 20;
  const auto file = text::open_regular_file(path);
  if (!file) return tl::unexpected(file.error());
  const auto unreadable = [&] {
    return fail(std::string("cannot be read: ") + std::strerror(errno), path.string());
  };
  struct stat about {};
  if (::fstat(::fileno(file->get()), &about) != 0) return unreadable();
  const auto file_bytes = static_cast<size_t>(about.st_size);
  const auto bytes = std::make_shared<std::string>();
  const auto read_to = [&](size_t end) {
    const size_t begin = bytes->size();
    bytes->resize(end);
    bytes->resize(begin + std::fread(bytes->data() + begin, 1, end - begin, file->get()));
  };
  read_to(streetmap::SegmentMap::kHeaderBytes);
  const auto checked = streetmap::SegmentMap::check_header(std::as_bytes(std::span(*bytes)),
                                                           file_bytes, path.string());
  if (!checked) return tl::unexpected(checked.error());
  if (file_bytes > kMaxBytes) {
    return fail("is longer than " + std::to_string(kMaxBytes) + " bytes", path.string(),
                "cut it with infuse streetmap --clip, or make it of larger cells");
  }
  bytes->reserve(file_bytes);
  read_to(file_bytes);
  if (std::ferror(file->get()) != 0) return unreadable();
  auto map = streetmap::SegmentMap::open(std::as_bytes(std::span(*bytes)), path.string());
  if (!map) return tl::unexpected(map.error());
  return StreetMapFile{bytes, *map, text::checksum(*bytes)};
}

bool is_image_file(const std::filesystem::path& input) {
  const std::string ending = input.extension().string();
  return ending == ".png" || ending == ".jpg" || ending == ".jpeg";
}

Result<GeneratedStreetMap> make_street_map(const std::filesystem::path& input,
                                           const StreetMapOptions& options) {
  if (!is_image_file(input)) return make_from_openstreetmap(input, options);
  if (!options.image) return fail("an image has no scale of its own", input.string());
  return make_from_image(input, *options.image);
}

}  // namespace infuse::daemon
