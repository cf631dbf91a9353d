#include "daemon/tools/map/map_export.hpp"

#include <spdlog/fmt/fmt.h>

#include <filesystem>
#include <iostream>
#include <optional>
#include <set>

#include "daemon/command_line/arguments.hpp"
#include "daemon/command_line/progress_line.hpp"
#include "daemon/drawing/plan_legend.hpp"
#include "daemon/mapping/cloud_file.hpp"
#include "daemon/mapping/geotiff_file.hpp"
#include "daemon/mapping/las_file.hpp"
#include "daemon/mapping/map_folder.hpp"
#include "daemon/mapping/map_image.hpp"
#include "daemon/mapping/static_clouds.hpp"
#include "drivers/camera/png_encoder.hpp"
#include "drivers/recording/atomic_file.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kMapExportProgram = "infuse map export";
constexpr double kMapPixel = 0.2, kMapVoxel = 0.25;  // m

bool is_geotiff(const std::string& extension) {
  return extension == ".tif" || extension == ".tiff";
}

/// Calls use(cloud, T_map_lidar) for every keyframe that has a cloud.
template <class Use>
Result<void> for_each_cloud(const MapFolder& folder, const MapContent& map, bool without_moving,
                            Use use) {
  ProgressLine line;
  StaticClouds static_clouds(folder, map);
  const size_t all = map.T_map_vehicle.size();
  for (size_t k = 0; k < all; ++k) {
    if (!map.drive.keyframes[k].keyframe.has_cloud) continue;
    const auto cloud =
        without_moving ? static_clouds.read(k) : folder.read_cloud(map.drive.keyframes, k);
    if (!cloud) return tl::unexpected(cloud.error());
    use(*cloud, map.T_map_vehicle[k] * map.drive.T_vehicle_lidar);
    line.show(static_cast<double>(k + 1) / static_cast<double>(all),
              fmt::format("{} of {} clouds", k + 1, all));
  }
  line.clear();
  if (without_moving && static_clouds.points() > 0) {
    std::cout << fmt::format("{} of {} points are of moving objects and left out, {:.2f} %\n",
                             static_clouds.removed(), static_clouds.points(),
                             100.0 * static_cast<double>(static_clouds.removed()) /
                                 static_cast<double>(static_clouds.points()));
  }
  return {};
}

std::optional<MapOrigin> origin_of(const MapContent& map) {
  const auto found = map.manifest.find("georeference");
  if (found == map.manifest.end() || !found->is_object()) return std::nullopt;
  return MapOrigin{.latitude = found->value("latitude_deg", 0.0),
                   .longitude = found->value("longitude_deg", 0.0),
                   .altitude = found->value("altitude_m", 0.0)};
}

Result<std::string> export_cloud(const MapFolder& folder, const MapContent& map, double voxel,
                                 bool without_moving, const std::string& extension) {
  // The submaps were cut at their own ranges: here every point counts.
  mapping::SubmapBuilder builder({.voxel_size = voxel, .min_range = 0, .max_range = 500});
  const auto done = for_each_cloud(folder, map, without_moving,
                                   [&](const mapping::Submap& cloud, const Eigen::Isometry3d& T) {
                                     builder.add(cloud.points(), cloud.reflectivity, T);
                                   });
  if (!done) return tl::unexpected(done.error());
  const mapping::Submap whole = builder.take();
  if (extension == ".las") return format_cloud_las(whole, origin_of(map));
  return extension == ".ply" ? format_cloud_ply(whole) : format_cloud_pcd(whole);
}

/// The drawing on the colour scale of fractions, black without points, with its legend.
CameraFrame coloured(const MapDrawing& drawing, double pixel, MapImageContent content,
                     bool north_up) {
  CameraFrame image = drawing.image;
  image.format = PixelFormat::kBgr8;
  image.pixels.clear();
  for (const uint8_t grey : drawing.image.pixels) {
    const Colour colour = grey == 0 ? Colour{} : fraction_colour((grey - 1) / 254.0);
    image.pixels.insert(image.pixels.end(), colour.begin(), colour.end());
  }
  const auto text = [&](float value) {
    return content == MapImageContent::kHeight ? fmt::format("height {:.1f} m", value)
                                               : fmt::format("reflectivity {:.0f} %", 100 * value);
  };
  add_legend(image, {pixel,
                     north_up,
                     {{text(drawing.low), fraction_colour(0)},
                      {text((drawing.low + drawing.high) / 2), fraction_colour(0.5)},
                      {text(drawing.high), fraction_colour(1)},
                      {"no points", {}}}});
  return image;
}

/// A GeoTIFF in UTM where the map is georeferenced, or an image in its frame.
Result<std::string> export_image(const MapFolder& folder, const MapContent& map, double pixel,
                                 bool without_moving, MapImageContent content, bool geotiff) {
  MapImage image(pixel);
  std::optional<MapProjection> projection;
  if (const auto origin = origin_of(map); geotiff && origin) {
    auto made = MapProjection::create(*origin);
    if (!made) return tl::unexpected(made.error());
    projection = *made;
  }
  const auto done = for_each_cloud(folder, map, without_moving,
                                   [&](const mapping::Submap& cloud, const Eigen::Isometry3d& T) {
                                     image.add(cloud, T, projection ? &*projection : nullptr);
                                   });
  if (!done) return tl::unexpected(done.error());
  if (geotiff) {
    return image.raster(content).and_then(
        [&](const MapRaster& raster) { return format_geotiff(raster, projection); });
  }
  return image.draw(content)
      .and_then([&](const MapDrawing& drawing) {
        return camera::encode_png(coloured(drawing, pixel, content, origin_of(map).has_value()));
      })
      .map([](const std::vector<uint8_t>& png) { return std::string(png.begin(), png.end()); });
}

Result<std::string> export_map(const MapExportArguments& arguments, const std::string& extension) {
  const MapFolder folder(arguments.map);
  const auto map = read_map(folder);
  if (!map) return tl::unexpected(map.error());
  const auto size = [&](double otherwise) {
    return arguments.voxel > 0 ? arguments.voxel : otherwise;
  };
  if (extension == ".tum") {
    const size_t drives = map->drive.first_keyframes.size();
    if (arguments.drive > drives) {
      return fail(fmt::format("there is no drive {}", arguments.drive), arguments.map,
                  fmt::format("the map has {}", drives));
    }
    return folder.read_stated(map->manifest, MapFolder::trajectory_name(arguments.drive - 1));
  }
  if (extension == ".png" || is_geotiff(extension)) {
    return export_image(
        folder, *map, size(kMapPixel), arguments.without_moving,
        arguments.show == "height" ? MapImageContent::kHeight : MapImageContent::kIntensity,
        is_geotiff(extension));
  }
  return export_cloud(folder, *map, size(kMapVoxel), arguments.without_moving, extension);
}

}  // namespace

int run_map_export(const MapExportArguments& arguments) {
  const std::string extension = std::filesystem::path(arguments.output).extension().string();
  const std::set<std::string> known{".pcd", ".ply", ".las", ".tum", ".png", ".tif", ".tiff"};
  if (!known.contains(extension)) {
    return print_error(kMapExportProgram,
                       {"unknown format '" + extension + "'", arguments.output,
                        "known are .pcd, .ply, .las, .tum, .png and .tif"},
                       kUsage);
  }
  if (extension == ".tum" && arguments.without_moving) {
    return print_error(kMapExportProgram,
                       {"--without-moving does not apply to a trajectory", arguments.output,
                        "it removes points from clouds and images"},
                       kUsage);
  }
  const auto bytes = export_map(arguments, extension);
  if (!bytes) return print_error(kMapExportProgram, bytes.error(), kUnreadable);
  const auto written = recording::write_file_atomically(
      arguments.output, std::as_bytes(std::span(bytes->data(), bytes->size())));
  if (!written) return print_error(kMapExportProgram, written.error(), kFailure);
  std::cout << fmt::format("{} written, {:.1f} MB\n", arguments.output,
                           static_cast<double>(bytes->size()) / 1e6);
  return kDone;
}

}  // namespace infuse::daemon
