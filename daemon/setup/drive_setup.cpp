#include "daemon/setup/drive_setup.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

#include "daemon/setup/bare_capture.hpp"
#include "drivers/makers/makers.hpp"
#include "drivers/recording/capture_parts.hpp"

namespace infuse::daemon {
namespace {

Result<lidar::InferredModel> infer_model(const makers::Stream* stream, const std::string& where) {
  const std::string advice = "give it with --model; " + makers::known_models();
  if (stream == nullptr) return fail("no lidar packets at its beginning", where, advice);
  const lidar::ModelInference& inference = *stream->inference;
  if (const auto inferred = inference.infer()) {
    return lidar::InferredModel{inferred->model, "inferred: " + inferred->reason};
  }
  if (inference.packets() < inference.min_packets()) {
    return fail(fmt::format("{} lidar packets are too few to infer the model", inference.packets()),
                where, advice);
  }
  return fail(fmt::format("{}'s packets, but of no known model: {}", stream->maker->name(),
                          inference.describe()),
              where,
              advice + "; sweeps of other lidars are read as PointCloud2 (infuse import) and PCD");
}

Result<lidar::InferredModel> choose_model(const std::string& configured,
                                          const makers::Stream* stream, const std::string& where,
                                          const lidar::LidarModel* requested) {
  if (requested == nullptr && configured.empty()) return infer_model(stream, where);
  const auto model = requested != nullptr ? requested : makers::find_model(configured);
  if (model == nullptr) {
    return fail(fmt::format("unknown model '{}'", configured), where, makers::known_models());
  }
  lidar::InferredModel chosen{model,
                              requested != nullptr ? "requested with --model" : "configured"};
  const auto inferred = stream != nullptr ? stream->inference->infer() : std::nullopt;
  if (inferred && inferred->model != model) chosen.reason += "; but " + inferred->reason;
  return chosen;
}

/// Model of a lidar, and the file of its unit's calibration; empty: there is none.
struct ChosenUnit {
  lidar::InferredModel model;
  std::filesystem::path calibration;
};

/// Chooses the model, and the calibration: `overrides`, that of the drive, or the one that the
/// maker finds for these packets.
Result<ChosenUnit> choose_unit(const recording::Drive& drive, const recording::LidarFiles& files,
                               const std::string& configured, const makers::Stream* stream,
                               const LidarOverrides& overrides) {
  const std::filesystem::path capture = drive.resolve(files.packets);
  std::filesystem::path calibration = overrides.calibration;
  if (calibration.empty() && !files.calibration.empty()) {
    calibration = drive.resolve(files.calibration);
  }
  if (stream != nullptr) {
    const auto stated = stream->maker->find_calibration(capture, calibration, *stream->inference);
    if (!stated) return tl::unexpected(stated.error());
    if (*stated) {
      calibration = (*stated)->calibration;
      if (overrides.model == nullptr && configured.empty()) {
        const std::string reason =
            fmt::format("stated by {}: {}", calibration.filename().string(), (*stated)->states);
        return ChosenUnit{{(*stated)->model, reason}, calibration};
      }
    }
  }
  const auto model = choose_model(configured, stream, capture.string(), overrides.model);
  if (!model) return tl::unexpected(model.error());
  const bool unused = files.calibration.empty() && !model->model->calibrated_per_unit;
  return ChosenUnit{*model, unused ? std::filesystem::path() : calibration};
}

/// Options of the configured lidar of that name; the defaults if there is none.
LidarOptions find_options(const std::string& name, const std::vector<LidarOptions>& lidars) {
  for (const LidarOptions& options : lidars) {
    if (options.name == name) return options;
  }
  return {};
}

std::string endpoint_of(const recording::LidarFiles& files) {
  if (files.packets.empty()) return files.sweeps;
  return fmt::format("port {} of {}{}", files.port, files.packets,
                     files.sender ? ", from " + address_text(*files.sender) : "");
}

/// Sets up one lidar whose data are packets.
Result<void> set_up_packets(const recording::Drive& drive, const recording::LidarFiles& files,
                            const std::string& configured, const LidarOptions& options,
                            const LidarOverrides& overrides, LidarSetup& lidar) {
  const std::filesystem::path capture = drive.resolve(files.packets);
  const auto survey = survey_beginning(capture);
  if (!survey) return tl::unexpected(survey.error());
  const makers::Stream* stream = find_data_stream(*survey, files);
  const auto chosen = choose_unit(drive, files, configured, stream, overrides);
  if (!chosen) return tl::unexpected(chosen.error());
  const lidar::LidarModel& model = *chosen->model.model;
  lidar.device.model = model.name;
  lidar.device.model_reason = chosen->model.reason;
  lidar::DecoderOptions& decoder = lidar.decoder;
  decoder.model = &model;
  decoder.cut_azimuth = options.cut_azimuth_deg;
  decoder.sender = files.sender.value_or(0);
  const auto check = [&] { return lidar::make_decoder(decoder).map([](const auto&) {}); };
  if (chosen->calibration.empty()) {
    if (auto usable = check(); !usable || !model.calibrated_per_unit) return usable;
    decoder.calibration = find_streamed_calibration(capture, files, decoder);
    return {};
  }
  auto loaded = model.maker->load_calibration(model, chosen->calibration);
  if (!loaded) return tl::unexpected(loaded.error());
  decoder.calibration = *loaded;
  return check();
}

/// Leaves out the lidars of a bare capture that cannot be set up, with a note of each, if others
/// can be.
void leave_out_unknown(recording::Drive& drive, const LidarOverrides& overrides,
                       std::vector<Error>& notes) {
  recording::DriveDescription& description = drive.description;
  std::vector<Error> wrong;
  std::vector<size_t> known;
  for (size_t i = 0; i < description.lidars.size(); ++i) {
    LidarSetup lidar;
    const auto done = set_up_packets(drive, description.lidars[i], description.rig.lidars[i].model,
                                     {}, overrides, lidar);
    if (done) {
      known.push_back(i);
    } else {
      wrong.push_back(done.error());
      wrong.back().where = endpoint_of(description.lidars[i]);
    }
  }
  if (known.empty() || wrong.empty()) return;
  for (size_t i = 0; i < known.size(); ++i) {
    std::swap(description.lidars[i], description.lidars[known[i]]);
    std::swap(description.rig.lidars[i], description.rig.lidars[known[i]]);
  }
  description.lidars.resize(known.size());
  description.rig.lidars.resize(known.size());
  if (description.rig.find_lidar(description.gnss_lidar) == nullptr) description.gnss_lidar = "";
  notes.insert(notes.end(), wrong.begin(), wrong.end());
}

Result<recording::Drive> find_drive(const std::filesystem::path& path,
                                    const std::vector<LidarOptions>& lidars,
                                    const LidarOverrides& overrides, std::vector<Error>& notes) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored) && !recording::is_capture_folder(path)) {
    return recording::Drive::open(path);
  }
  const auto survey = survey_beginning(path);
  if (!survey) return tl::unexpected(survey.error());
  auto drive = describe_capture(path, *survey, lidars);
  if (drive && lidars.empty() && drive->description.lidars.size() > 1) {
    leave_out_unknown(*drive, overrides, notes);
  }
  return drive;
}

uint64_t size_of_capture(const std::filesystem::path& path) {
  uint64_t size = 0;
  const auto parts = recording::find_capture_parts(path);
  if (!parts) return 0;
  for (const std::filesystem::path& part : *parts) {
    std::error_code error;
    const auto bytes = std::filesystem::file_size(part, error);
    if (!error) size += bytes;
  }
  return size;
}

/// Sets up the lidars of a drive.
Result<void> set_up_lidars(const recording::Drive& drive, const std::vector<LidarOptions>& lidars,
                           const LidarOverrides& overrides, SensorSetup& setup) {
  const recording::DriveDescription& description = drive.description;
  std::vector<std::string> captures;
  for (size_t i = 0; i < description.lidars.size(); ++i) {
    const LidarMount& mount = description.rig.lidars[i];
    const recording::LidarFiles& files = description.lidars[i];
    LidarSetup lidar{{mount.name, "lidar", mount.model.empty() ? "unknown" : mount.model,
                      "configured", endpoint_of(files), std::nullopt},
                     !files.packets.empty(),
                     {},
                     mount.T_vehicle_lidar};
    if (lidar.has_packets) {
      const auto set_up = set_up_packets(drive, files, mount.model,
                                         find_options(mount.name, lidars), overrides, lidar);
      if (!set_up) return tl::unexpected(set_up.error());
      if (std::find(captures.begin(), captures.end(), files.packets) == captures.end()) {
        captures.push_back(files.packets);
        setup.capture_bytes += size_of_capture(drive.resolve(files.packets));
      }
    }
    setup.lidars.push_back(std::move(lidar));
  }
  return {};
}

void set_up_cameras(const recording::DriveDescription& description, SensorSetup& setup) {
  for (size_t i = 0; i < description.cameras.size(); ++i) {
    const CameraMount& mount = description.rig.cameras[i];
    const recording::CameraFiles& files = description.cameras[i];
    const bool name_in_use = description.rig.find_lidar(mount.name) != nullptr;
    const bool pinhole = mount.intrinsics.model == CameraIntrinsics::Model::kPinhole;
    setup.cameras.push_back(
        {{(name_in_use ? "camera " : "") + mount.name, "camera", pinhole ? "pinhole" : "fisheye",
          "configured", files.images, std::nullopt},
         {.bayer = files.mosaic, .grey = files.grey}});
  }
}

/// Sets up the GNSS receiver that is connected to a lidar.
void set_up_gnss_lidar(const recording::DriveDescription& description, SensorSetup& setup) {
  if (description.gnss_lidar.empty()) return;
  size_t lidar = 0;
  while (setup.lidars[lidar].device.name != description.gnss_lidar) ++lidar;
  setup.gnss_lidar = LidarIndex(lidar);
  setup.vehicle.gnss = Device{"gnss",
                              "gnss",
                              "NMEA",
                              "position packets carry NMEA sentences",
                              "position packets of " + description.gnss_lidar,
                              std::nullopt};
}

}  // namespace

Result<const lidar::LidarModel*> requested_model(const std::string& name) {
  if (name.empty()) return nullptr;
  return makers::require_model(name, "--model");
}

Result<SensorSetup> open_drive(const std::filesystem::path& path,
                               const std::vector<LidarOptions>& lidars,
                               const LidarOverrides& overrides) {
  SensorSetup setup;
  const auto drive = find_drive(path, lidars, overrides, setup.doubts);
  if (!drive) return tl::unexpected(drive.error());
  auto source = recording::DriveSource::open(*drive);
  if (!source) return tl::unexpected(source.error());
  setup.path = path;
  setup.source = *std::move(source);
  setup.rig = drive->description.rig;
  if (auto done = set_up_lidars(*drive, lidars, overrides, setup); !done) {
    return tl::unexpected(done.error());
  }
  set_up_cameras(drive->description, setup);
  auto vehicle = set_up_vehicle(*drive);
  if (!vehicle) return tl::unexpected(vehicle.error());
  setup.vehicle = *std::move(vehicle);
  set_up_gnss_lidar(drive->description, setup);
  return setup;
}

}  // namespace infuse::daemon
