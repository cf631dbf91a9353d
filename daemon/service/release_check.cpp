#include "daemon/service/release_check.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <ostream>

#include "daemon/calibration/saved_calibrations.hpp"
#include "daemon/command_line/version.hpp"
#include "daemon/history/history_file.hpp"
#include "daemon/history/saved_state.hpp"
#include "daemon/pipeline/pipeline.hpp"
#include "daemon/service/config_check.hpp"
#include "daemon/setup/live_setup.hpp"
#include "drivers/makers/makers.hpp"
#include "drivers/recording/atomic_file.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kMaxStateBytes = kMaxCalibrationsBytes;  // the larger of the two files
constexpr double kGeneratedRadius = 10;                   // m
constexpr double kRadiusTolerance = 0.1;                  // m: the beams' origins
constexpr Duration kGeneratedDuration{320'000'000};       // three turns
constexpr uint64_t kMinRightSweeps = 2;                   // whole ones of these
constexpr Stamp kGeneratedStart = Stamp::from_ns(1'700'000'000'000'000'000);

ExitCode report_failure(const Error& error, ExitCode code, std::ostream& out) {
  out << "failed: " << error.message() << "\n";
  return code;
}

ExitCode test_maps(const Config& config, std::ostream& out) {
  if (const auto maps = check_maps(config); !maps) {
    return report_failure(maps.error(), kUnreadable, out);
  }
  out << "ok: maps\n";
  return kDone;
}

/// What the parser says of a file; empty if it can be read, or is not there.
template <class Parse>
std::string damage_of(const std::filesystem::path& file, Parse parse) {
  const auto text = text::read_text(file, kMaxStateBytes);
  if (!text) return "";
  const auto parsed = parse(*text);
  return parsed ? "" : parsed.error().what;
}

ExitCode test_history(const std::filesystem::path& state, std::ostream& out) {
  const auto lines = read_history(state / kHistoryFile);
  if (!lines) return report_failure(lines.error(), kUnreadable, out);
  size_t unreadable = 0;
  for (const std::string& line : *lines) {
    const auto json = nlohmann::json::parse(line, nullptr, false);
    unreadable += json.is_object() && json.value("form", nlohmann::json()) == kHistoryForm ? 0 : 1;
  }
  out << "ok: " << kHistoryFile << ", " << lines->size() << " lines\n";
  if (unreadable > 0) {
    out << "note: " << unreadable << " of them are damaged or of another release; they are kept\n";
  }
  return kDone;
}

ExitCode test_writing(const std::filesystem::path& state, std::ostream& out) {
  const std::filesystem::path file = state / ".self-test";
  const std::string_view text = "infused --self-test\n";
  const auto written = recording::write_file_atomically(file, std::as_bytes(std::span(text)), 0600);
  std::error_code ignored;
  std::filesystem::remove(file, ignored);
  if (!written) return report_failure(written.error(), kFailure, out);
  out << "ok: " << state.string() << " can be written\n";
  return kDone;
}

ExitCode test_state(const std::filesystem::path& state, std::ostream& out) {
  if (state.empty()) {
    out << "note: no state directory: neither --state nor $STATE_DIRECTORY\n";
    return kDone;
  }
  const std::filesystem::path runs = state / kSavedStateFile, cameras = state / kCalibrationsFile;
  ExitCode code = test_writing(state, out);
  const auto keep = [&](ExitCode next) {
    if (code == kDone) code = next;
  };
  keep(test_state_file(runs, kSavedStateForm, damage_of(runs, parse_state), out));
  keep(test_state_file(cameras, kCalibrationsForm, damage_of(cameras, parse_calibrations), out));
  keep(test_history(state, out));
  return code;
}

/// The maker's first model that has an example; null if there is none.
const lidar::LidarModel* find_example(const lidar::LidarMaker& maker) {
  for (const lidar::LidarModel& model : maker.models()) {
    if (!maker.example_packet(model, 0, kGeneratedRadius).empty()) return &model;
  }
  return nullptr;
}

SensorSetup generated_setup(const lidar::LidarModel& model) {
  SensorSetup setup;
  LidarSetup lidar{
      {"self-test", "lidar", model.name, "generated", "generated", std::nullopt}, true, {}};
  lidar.decoder.model = &model;
  setup.lidars.push_back(lidar);
  setup.rig.lidars.push_back(LidarMount{"self-test", model.name});
  return setup;
}

void feed_generated(Intake& intake, const lidar::LidarModel& model) {
  const Duration period = model.maker->example_period(model);
  const uint16_t port = model.maker->ports().data;
  intake.start(kGeneratedStart);
  Stamp stamp = kGeneratedStart;
  for (uint32_t i = 0; stamp < kGeneratedStart + kGeneratedDuration; ++i) {
    const auto payload = model.maker->example_packet(model, i, kGeneratedRadius);
    stamp = kGeneratedStart + (i + 1) * period;
    intake.advance(stamp);
    intake.add_datagram(LidarIndex(0), {stamp, 0x0A00'0001, port, port, payload});
  }
  intake.end(stamp);
}

/// Decodes generated turns of a model through the threads of a pipeline.
Result<void> decode_turns(const lidar::LidarModel& model) {
  const SensorSetup setup = generated_setup(model);
  boost::asio::io_context io(1);
  Server server(io, {}, version(), "0000000000000000");
  PipelineOptions options;
  options.odometry.use_lidar = false;
  Pipeline pipeline(io, setup, options, server, nullptr,
                    [&] { server.finish(std::chrono::milliseconds(0)); });
  uint64_t right = 0;
  pipeline.publisher().add_line_listener(
      [&](ReportClass report_class, const std::string&, const std::string& line) {
        if (report_class != ReportClass::kSweep) return;
        const auto json = nlohmann::json::parse(line, nullptr, false);
        const auto range = json.find("mean_range");
        const bool near = range != json.end() && range->is_number() &&
                          std::abs(range->get<double>() - kGeneratedRadius) < kRadiusTolerance;
        right += near ? 1 : 0;
      });
  pipeline.start([&](std::stop_token) { feed_generated(pipeline.intake(), model); });
  io.run();
  if (right >= kMinRightSweeps) return {};
  return fail("generated packets of a " + std::string(model.name) + " gave " +
              std::to_string(right) + " right sweeps of " +
              std::to_string(pipeline.publisher().totals().sweeps));
}

}  // namespace

ExitCode test_state_file(const std::filesystem::path& file, int form, const std::string& damage,
                         std::ostream& out) {
  std::error_code ignored;
  const std::string name = file.filename().string();
  if (!std::filesystem::exists(file, ignored)) {
    out << "ok: " << name << " does not exist yet\n";
    return kDone;
  }
  const auto text = text::read_text(file, kMaxStateBytes);
  if (!text) return report_failure(text.error(), kUnreadable, out);
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  const bool versioned =
      json.is_object() && json.contains("form") && json["form"].is_number_unsigned();
  if (versioned && json["form"].get<uint64_t>() > static_cast<uint64_t>(form)) {
    return report_failure({"written by a newer release: form " + json["form"].dump() +
                               ", this one reads up to " + std::to_string(form),
                           file.string(), "this release would set it aside as *.unreadable"},
                          kFailure, out);
  }
  if (!damage.empty()) {
    out << "note: " << file.string() << ": " << damage
        << "; the daemon begins a new one and keeps this as *.unreadable\n";
    return kDone;
  }
  out << "ok: " << name << "\n";
  return kDone;
}

Result<void> decode_generated_turns() {
  for (const lidar::LidarMaker* maker : makers::all()) {
    const lidar::LidarModel* model = find_example(*maker);
    if (model == nullptr) continue;
    if (auto decoded = decode_turns(*model); !decoded) return decoded;
  }
  return {};
}

ExitCode self_test(const Config& config, const std::filesystem::path& state, std::ostream& out) {
  const auto setup = set_up_live(config);
  if (!setup) return report_failure(setup.error(), kUsage, out);
  out << "ok: configuration, " << setup->sensors().size() << " sensors\n";
  ExitCode code = test_maps(config, out);
  const ExitCode of_state = test_state(state, out);
  if (code == kDone) code = of_state;
  if (const auto decoded = decode_generated_turns(); !decoded) {
    const ExitCode failed = report_failure(decoded.error(), kFailure, out);
    return code == kDone ? failed : code;
  }
  out << "ok: generated packets went through the pipeline\n";
  return code;
}

}  // namespace infuse::daemon
