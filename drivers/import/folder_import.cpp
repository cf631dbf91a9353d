#include "drivers/import/folder_import.hpp"

#include <algorithm>
#include <memory>
#include <set>

#include "drivers/import/image_size.hpp"
#include "drivers/import/import_files.hpp"
#include "drivers/makers/makers.hpp"
#include "drivers/recording/capture_parts.hpp"
#include "drivers/recording/capture_reader.hpp"
#include "drivers/recording/drive_table.hpp"
#include "drivers/recording/toml_table.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::importers {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxFolderSensors = 64;

std::string seconds_text(Stamp stamp) {
  const std::string ms = std::to_string(stamp.ns() / 1'000'000 % 1000 + 1000);
  return std::to_string(stamp.ns() / 1'000'000'000) + "." + ms.substr(1) + " s";
}

/// An error at the line of a key, or of the table if it has none.
tl::unexpected<Error> fail_at(const toml::table& table, const std::string& file,
                              const std::string& key, const std::string& what,
                              const std::string& hint = "") {
  recording::TomlTable at(table, file, "");
  at.report_error(key, what, hint);
  return tl::unexpected(*at.finish());
}

/// Removes the `stamps` table from a sensor's.
Result<std::optional<StampRule>> extract_stamps(toml::table& sensor, const std::string& file) {
  const toml::node* node = sensor.get("stamps");
  if (node == nullptr) return std::nullopt;
  if (!node->is_table())
    return fail_at(sensor, file, "stamps", "stamps must be a table: { file = \"stamps.csv\" }");
  const auto rule = read_stamp_rule(*node->as_table(), file);
  if (!rule) return tl::unexpected(rule.error());
  sensor.erase("stamps");
  return *rule;
}

/// Tables of an array; empty if it is none, which `parse_drive` reports.
std::vector<toml::table*> tables_of(toml::table& root, std::string_view key) {
  std::vector<toml::table*> tables;
  toml::node* node = root.get(key);
  if (node == nullptr || !node->is_array()) return tables;
  for (toml::node& item : *node->as_array()) {
    if (item.is_table() && tables.size() < kMaxFolderSensors) tables.push_back(item.as_table());
  }
  return tables;
}

/// Time that measurements cover.
struct TimeSpan {
  Stamp first = Stamp::latest(), last = Stamp::earliest();
  bool empty() const { return last < first; }
  void add(Stamp stamp) {
    first = std::min(first, stamp);
    last = std::max(last, stamp);
  }
};

/// Checks what a description names, then writes the drive.
class FolderImport {
 public:
  FolderImport(FolderDescription description, fs::path file)
      : folder_(std::move(description)), file_(std::move(file)), base_(file_.parent_path()) {
    if (base_.empty()) base_ = ".";
    lidar_tables_ = tables_of(folder_.table, "lidar");
    camera_tables_ = tables_of(folder_.table, "camera");
  }

  Result<void> check() {
    auto& drive = folder_.drive;
    for (size_t k = 0; k < drive.lidars.size(); ++k) {
      if (auto done = drive.lidars[k].packets.empty() ? check_sweeps(k) : check_packets(k); !done)
        return done;
    }
    for (size_t k = 0; k < drive.cameras.size(); ++k) {
      if (auto done = check_images(k); !done) return done;
    }
    return check_others();
  }

  Result<FolderImportSummary> write(const fs::path& drive) {
    if (auto made = make_empty_folder(drive); !made) return tl::unexpected(made.error());
    // Numbered files first: no linked file may be in the place of their times.csv.
    for (const auto& [folder, files] : sequences_) {
      if (auto done = link_sequence(files, drive / folder); !done)
        return tl::unexpected(done.error());
    }
    for (const fs::path& file : others_) {
      const fs::path relative = file.lexically_relative(base_);
      if (auto done = link_file(file, drive / relative); !done) return tl::unexpected(done.error());
    }
    if (auto done = recording::write_drive_toml(drive, folder_.drive); !done)
      return tl::unexpected(done.error());
    const auto opened = recording::Drive::open(drive);
    if (!opened) return tl::unexpected(opened.error());
    return std::move(summary_);
  }

 private:
  tl::unexpected<Error> fail_key(const toml::table& table, const std::string& key,
                                 const std::string& what, const std::string& hint = "") const {
    return fail_at(table, file_.string(), key, what, hint);
  }

  Result<void> check_packets(size_t k) {
    auto& files = folder_.drive.lidars[k];
    const toml::table& table = *lidar_tables_[k];
    std::error_code ignored;
    const fs::path path = base_ / files.packets;
    if (!fs::is_regular_file(path, ignored))
      return fail_key(table, "packets", "there is no file '" + files.packets + "'");
    const auto parts = recording::find_capture_parts(path);
    if (!parts) return fail_key(table, "packets", parts.error().what);
    auto reader = recording::CaptureReader::open(path);
    if (!reader) return fail_key(table, "packets", reader.error().message());
    std::unique_ptr<lidar::ModelInference> inference;
    std::set<uint16_t> ports;
    size_t packets = 0;
    for (Datagram datagram; reader->next(datagram);) {
      const lidar::ClassifiedPacket packet = makers::classify(datagram.payload);
      if (packet.packet_class != lidar::PacketClass::kData) continue;
      if (ports.size() < 8) ports.insert(datagram.destination_port);
      if (datagram.destination_port != files.port ||
          (files.sender && datagram.sender != *files.sender))
        continue;
      ++packets;
      lidar_time_.add(datagram.stamp);
      if (inference == nullptr) inference = packet.maker->make_inference();
      inference->add(datagram.payload);
    }
    if (packets == 0) {
      std::string seen;
      for (const uint16_t port : ports) seen += (seen.empty() ? "" : ", ") + std::to_string(port);
      return fail_key(table,
                      files.sender         ? "sender"
                      : files.port != 2368 ? "port"
                                           : "packets",
                      "'" + files.packets + "' has no data packets of a lidar to port " +
                          std::to_string(files.port),
                      seen.empty() ? "there are none to other ports" : "there are to: " + seen);
    }
    std::string& model = folder_.drive.rig.lidars[k].model;
    const lidar::LidarModel* inferred = inference->judge();
    if (model.empty() && inferred == nullptr) {
      return fail_key(table, "model", "the model of the lidar is not clear from its packets",
                      "give model; " + inference->describe());
    }
    if (model.empty()) model = inferred->name;
    summary_.packets += packets;
    others_.insert(others_.end(), parts->begin(), parts->end());
    reader->append_notes(summary_.notes);
    return {};
  }

  Result<std::vector<StampedFile>> read_sequence(const toml::table& table, const std::string& key,
                                                 const std::string& folder, const StampRule& rule,
                                                 const std::vector<std::string>& extensions) {
    const auto files = list_in_order(base_ / folder, extensions);
    if (!files) return fail_key(table, key, files.error().message());
    if (rule.rate_hz && !rule.start && lidar_time_.empty())
      return fail_key(table, key, "stamps: start is missing: there are no packets to begin with");
    auto stamped = stamp_files(*files, rule, base_, lidar_time_.first, summary_.notes);
    // The error is of a table or file that has a place of its own.
    if (!stamped) return stamped;
    if (rule.rate_hz) {
      summary_.notes.push_back({"the stamps follow from rate_hz: they are not measured",
                                (base_ / folder).string(),
                                "calibrate only with a standing vehicle"});
    }
    return stamped;
  }

  Result<void> check_sweeps(size_t k) {
    auto& files = folder_.drive.lidars[k];
    auto stamped = read_sequence(*lidar_tables_[k], "sweeps", files.sweeps, *folder_.lidars[k],
                                 {".bin", ".pcd"});
    if (!stamped) return tl::unexpected(stamped.error());
    for (const StampedFile& file : *stamped) lidar_time_.add(file.times.stamp);
    summary_.sweeps += stamped->size();
    files.sweeps = sequence_folder("sweeps_", folder_.drive.rig.lidars[k].name);
    sequences_.emplace_back(files.sweeps, std::move(*stamped));
    return {};
  }

  Result<void> check_images(size_t k) {
    auto& files = folder_.drive.cameras[k];
    const toml::table& table = *camera_tables_[k];
    const CameraMount& mount = folder_.drive.rig.cameras[k];
    auto stamped =
        read_sequence(table, "images", files.images, folder_.cameras[k], {".png", ".jpg", ".jpeg"});
    if (!stamped) return tl::unexpected(stamped.error());
    size_t within = 0;
    TimeSpan images;
    for (const StampedFile& file : *stamped) {
      const auto size = read_image_size(file.path);
      if (!size) return fail("is neither a PNG nor a JPEG image", file.path.string());
      if (size->width != mount.intrinsics.width || size->height != mount.intrinsics.height) {
        return fail_key(table, "width",
                        "the images are " + std::to_string(mount.intrinsics.width) + "x" +
                            std::to_string(mount.intrinsics.height) + ", but " +
                            file.path.filename().string() + " is " + std::to_string(size->width) +
                            "x" + std::to_string(size->height),
                        "fx, fy, cx and cy belong to the size");
      }
      images.add(file.times.stamp);
      if (file.times.stamp >= lidar_time_.first && file.times.stamp <= lidar_time_.last) ++within;
    }
    if (within == 0) {
      return fail_key(table, "images", "no image is within the time of the lidars",
                      "images: " + seconds_text(images.first) + " to " + seconds_text(images.last) +
                          ", lidars: " + seconds_text(lidar_time_.first) + " to " +
                          seconds_text(lidar_time_.last) + "; another unit, or offset_s?");
    }
    if (within < stamped->size()) {
      summary_.notes.push_back({std::to_string(stamped->size() - within) + " of " +
                                    std::to_string(stamped->size()) +
                                    " images are before or after the lidars' measurements",
                                (base_ / files.images).string(), ""});
    }
    summary_.images += stamped->size();
    files.images = sequence_folder("images_", mount.name);
    sequences_.emplace_back(files.images, std::move(*stamped));
    return {};
  }

  /// A folder of the drive that no other sensor has.
  std::string sequence_folder(const std::string& prefix, const std::string& sensor) const {
    std::string name = prefix;
    for (const char c : sensor) {
      const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_';
      name += plain ? c : '_';
    }
    const auto is_taken = [&](const std::string& folder) {
      return std::ranges::any_of(sequences_, [&](const auto& s) { return s.first == folder; });
    };
    std::string unique = name;
    for (int k = 2; is_taken(unique); ++k) unique = name + "_" + std::to_string(k);
    return unique;
  }

  /// Files that are linked as they are.
  Result<void> check_others() {
    const auto& drive = folder_.drive;
    std::vector<std::string> names = {drive.speed, drive.imu,         drive.gnss,
                                      drive.map,   drive.truth_poses, drive.truth_rig};
    for (const auto& lidar : drive.lidars) names.push_back(lidar.calibration);
    if (drive.can) names.insert(names.end(), {drive.can->log, drive.can->dbc});
    for (const std::string& name : names) {
      if (name.empty()) continue;
      std::error_code ignored;
      if (!fs::is_regular_file(base_ / name, ignored))
        return fail("there is no file '" + name + "'", file_.string());
      others_.push_back(base_ / name);
    }
    for (const fs::path& path : others_) {
      const fs::path relative = path.lexically_relative(base_).lexically_normal();
      if (relative == "drive.toml") {
        return fail("'drive.toml' is the name of the drive's own description", file_.string(),
                    "choose another name for the file");
      }
    }
    return {};
  }

  FolderDescription folder_;
  fs::path file_, base_;
  std::vector<toml::table*> lidar_tables_, camera_tables_;
  TimeSpan lidar_time_;
  std::vector<std::pair<std::string, std::vector<StampedFile>>> sequences_;  ///< by their folder
  std::vector<fs::path> others_;
  FolderImportSummary summary_;
};

}  // namespace

Result<FolderDescription> parse_folder(std::string_view text, const std::string& file) {
  auto table = recording::parse_toml(text, file);
  if (!table) return tl::unexpected(table.error());
  FolderDescription folder;
  folder.table = std::move(*table);
  std::vector<std::optional<StampRule>> rules;
  for (const char* key : {"lidar", "camera"}) {
    for (toml::table* sensor : tables_of(folder.table, key)) {
      auto rule = extract_stamps(*sensor, file);
      if (!rule) return tl::unexpected(rule.error());
      rules.push_back(std::move(*rule));
    }
  }
  auto drive = recording::parse_drive(folder.table, file);
  if (!drive) return tl::unexpected(drive.error());
  folder.drive = std::move(*drive);
  const auto lidars = tables_of(folder.table, "lidar"), cameras = tables_of(folder.table, "camera");
  if (lidars.empty()) return fail("has no [[lidar]]", file);
  for (size_t k = 0; k < lidars.size(); ++k) {
    const bool has_sweeps = folder.drive.lidars[k].packets.empty();
    if (has_sweeps && !rules[k])
      return fail_at(*lidars[k], file, "sweeps", "a lidar with sweeps must have stamps");
    if (!has_sweeps && rules[k])
      return fail_at(*lidars[k], file, "packets",
                     "packets have stamps of their own: leave out stamps");
    folder.lidars.push_back(rules[k]);
  }
  for (size_t k = 0; k < cameras.size(); ++k) {
    const auto& rule = rules[lidars.size() + k];
    if (!rule) {
      return fail_at(*cameras[k], file, "images", "a camera must have stamps",
                     "stamps = { file = \"stamps.csv\" }, { names = true } or { rate_hz = 10 }");
    }
    folder.cameras.push_back(*rule);
  }
  return folder;
}

Result<FolderImportSummary> import_folder(const fs::path& description, const fs::path& drive) {
  const auto text = text::read_text(description, recording::kMaxTomlBytes);
  if (!text) return tl::unexpected(text.error());
  auto folder = parse_folder(*text, description.string());
  if (!folder) return tl::unexpected(folder.error());
  FolderImport import(std::move(*folder), description);
  if (auto done = import.check(); !done) return tl::unexpected(done.error());
  return import.write(drive);
}

}  // namespace infuse::importers
