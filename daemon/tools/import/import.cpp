#include "daemon/tools/import/import.hpp"

#include <spdlog/fmt/fmt.h>

#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/protocol/json.hpp"
#include "daemon/tools/import/drive_delay.hpp"
#include "drivers/import/bag_import.hpp"
#include "drivers/import/folder_import.hpp"
#include "drivers/import/ford_import.hpp"
#include "drivers/import/kitti_import.hpp"
#include "drivers/import/lcm_import.hpp"
#include "drivers/import/opencalib_import.hpp"

namespace infuse::daemon {
namespace {

struct ImportArguments {
  std::string source;
  std::string drive;
  bool json = false;
};

int run_kitti(const ImportArguments& arguments) {
  auto imported = importers::import_kitti(arguments.source, arguments.drive);
  if (!imported) return print_error("infuse import kitti", imported.error(), kUnreadable);
  find_inertial_delay(arguments.drive, imported->notes);
  if (arguments.json) {
    Json json = {{"layout", importers::name_of(imported->layout)},
                 {"drive", arguments.drive},
                 {"sweeps", imported->sweeps},
                 {"images", imported->images},
                 {"poses", imported->poses},
                 {"times_trusted", imported->times_trusted},
                 {"notes", Json::array()}};
    for (const Error& note : imported->notes) json["notes"].push_back(note.message());
    std::cout << json_text(json) << "\n";
    return kDone;
  }
  std::cout << fmt::format("{}: {} sweeps, {} images, {} poses from KITTI's {} layout{}\n",
                           arguments.drive, imported->sweeps, imported->images, imported->poses,
                           importers::name_of(imported->layout),
                           imported->times_trusted ? "" : "; it has no times, they are synthetic");
  for (const Error& note : imported->notes) std::cout << "  note: " << note.message() << "\n";
  return kDone;
}

int run_opencalib(const ImportArguments& arguments) {
  const auto imported = importers::import_opencalib(arguments.source, arguments.drive);
  if (!imported) return print_error("infuse import opencalib", imported.error(), kUnreadable);
  if (arguments.json) {
    std::cout << json_text({{"drive", arguments.drive}, {"sweeps", 1}, {"images", 1}}) << "\n";
  } else {
    std::cout << fmt::format("{}: a sweep and an image; their time is synthetic\n",
                             arguments.drive);
  }
  return kDone;
}

int run_folder(const ImportArguments& arguments) {
  auto imported = importers::import_folder(arguments.source, arguments.drive);
  if (!imported) return print_error("infuse import folder", imported.error(), kUnreadable);
  find_inertial_delay(arguments.drive, imported->notes);
  if (arguments.json) {
    Json json = {{"drive", arguments.drive},
                 {"packets", imported->packets},
                 {"sweeps", imported->sweeps},
                 {"images", imported->images},
                 {"notes", Json::array()}};
    for (const Error& note : imported->notes) json["notes"].push_back(note.message());
    std::cout << json_text(json) << "\n";
    return kDone;
  }
  std::cout << fmt::format("{}: {} packets, {} sweeps, {} images\n", arguments.drive,
                           imported->packets, imported->sweeps, imported->images);
  for (const Error& note : imported->notes) std::cout << "  note: " << note.message() << "\n";
  return kDone;
}

struct BagArguments {
  std::vector<std::string> files;
  std::string drive;
  std::vector<std::string> topics;
  std::string vehicle_frame = importers::BagImportOptions().vehicle_frame;
  bool json = false;
};

/// How far the header stamps of a topic are from its log times; empty if it has none.
std::string lag_text(const importers::StampLag& lag) {
  if (lag.messages == 0) return "";
  return fmt::format("stamps {:.3f} s before the log times ({:.3f} to {:.3f})", lag.median,
                     lag.smallest, lag.largest);
}

void print_topics(const importers::BagImportSummary& imported) {
  for (const importers::BagTopic& topic : imported.survey.topics) {
    const std::string use = imported.use_of(topic.name);
    const auto reason = imported.selection.reasons.find(topic.name);
    std::string text = use.empty() ? "not taken" : use;
    if (use.empty() && reason != imported.selection.reasons.end()) text += ": " + reason->second;
    if (!use.empty() && topic.lag.messages > 0) text += "; " + lag_text(topic.lag);
    if (topic.stampless > 0)
      text += fmt::format("; {} without a stamp, their log times are used", topic.stampless);
    std::cout << fmt::format("  {:<34} {:>7} {:<32} {}\n", topic.name, topic.messages, topic.type,
                             text);
  }
}

Json topics_json(const importers::BagImportSummary& imported) {
  Json topics = Json::array();
  for (const importers::BagTopic& topic : imported.survey.topics) {
    Json entry = {{"topic", topic.name}, {"type", topic.type}, {"messages", topic.messages}};
    const std::string use = imported.use_of(topic.name);
    if (!use.empty()) entry["use"] = use;
    const auto reason = imported.selection.reasons.find(topic.name);
    if (reason != imported.selection.reasons.end()) entry["reason"] = reason->second;
    if (topic.lag.messages > 0) {
      entry["lag_s"] = {{"median", topic.lag.median},
                        {"smallest", topic.lag.smallest},
                        {"largest", topic.lag.largest}};
    }
    topics.push_back(entry);
  }
  return topics;
}

int run_rosbag(const BagArguments& arguments) {
  auto imported = importers::import_bags(
      {arguments.files.begin(), arguments.files.end()}, arguments.drive,
      {{arguments.topics.begin(), arguments.topics.end()}, arguments.vehicle_frame});
  if (!imported) return print_error("infuse import rosbag", imported.error(), kUnreadable);
  find_inertial_delay(arguments.drive, imported->notes);
  if (arguments.json) {
    Json json = {{"drive", arguments.drive},   {"packets", imported->packets},
                 {"sweeps", imported->sweeps}, {"images", imported->images},
                 {"speeds", imported->speeds}, {"imu_samples", imported->imu_samples},
                 {"fixes", imported->fixes},   {"topics", topics_json(*imported)},
                 {"notes", Json::array()}};
    for (const Error& note : imported->notes) json["notes"].push_back(note.message());
    std::cout << json_text(json) << "\n";
    return kDone;
  }
  std::cout << fmt::format(
      "{}: {} packets, {} sweeps, {} images, {} speeds, {} inertial samples, {} fixes\n",
      arguments.drive, imported->packets, imported->sweeps, imported->images, imported->speeds,
      imported->imu_samples, imported->fixes);
  print_topics(*imported);
  for (const Error& note : imported->notes) std::cout << "  note: " << note.message() << "\n";
  return kDone;
}

std::shared_ptr<BagArguments> declare_rosbag(CLI::App* app) {
  auto arguments = std::make_shared<BagArguments>();
  app->add_option(
         "FILE", arguments->files,
         "recording of rosbag2 (a folder, .mcap, .db3) or bag of ROS 1; several are read in this "
         "order")
      ->required();
  app->add_option("-o,--output", arguments->drive, "drive folder to create")
      ->required()
      ->type_name("DRIVE");
  app->add_option("--topic", arguments->topics,
                  "of the topics of a kind (lidar, camera, speed, inertial unit, GNSS) take this "
                  "one; may be repeated")
      ->type_name("TOPIC")
      ->allow_extra_args(false);
  app->add_option("--vehicle-frame", arguments->vehicle_frame,
                  "name of the vehicle frame in the transforms (base_link)")
      ->type_name("FRAME");
  app->add_flag("--json", arguments->json, "print the result as one JSON object");
  set_examples(*app, {"infuse import rosbag drive.mcap -o drive/",
                      "infuse import rosbag a.bag b.bag --topic /imu/data -o drive/"});
  return arguments;
}

struct LcmArguments {
  std::vector<std::string> files;
  std::string drive;
  bool json = false;
};

Json channels_json(const importers::LcmImportSummary& imported) {
  Json channels = Json::array();
  for (const importers::LcmChannel& channel : imported.channels) {
    Json entry = {{"channel", channel.name},
                  {"messages", channel.messages},
                  {"rate_hz", channel.rate_hz()},
                  {"smallest_bytes", channel.smallest},
                  {"largest_bytes", channel.largest}};
    if (!channel.use.empty()) entry["use"] = channel.use;
    if (channel.lag.messages > 0) {
      entry["lag_s"] = {{"median", channel.lag.median},
                        {"smallest", channel.lag.smallest},
                        {"largest", channel.lag.largest}};
    }
    channels.push_back(entry);
  }
  return channels;
}

void print_channel(const importers::LcmChannel& channel) {
  std::string text = channel.use.empty() ? "not taken: no packets of a lidar" : channel.use;
  if (channel.use.empty() && channel.has_positions) text = "not taken";
  const std::string lag = lag_text(channel.lag);
  if (!channel.use.empty()) text += "; " + (lag.empty() ? "stamps are the log times" : lag);
  const std::string size = channel.smallest == channel.largest
                               ? std::to_string(channel.largest)
                               : fmt::format("{}-{}", channel.smallest, channel.largest);
  std::cout << fmt::format("  {:<24} {:>8} at {:>8.2f} Hz, {:>12} bytes  {}\n", channel.name,
                           channel.messages, channel.rate_hz(), size, text);
}

int run_lcm(const LcmArguments& arguments) {
  auto imported =
      importers::import_lcm({arguments.files.begin(), arguments.files.end()}, arguments.drive);
  if (!imported) return print_error("infuse import lcm", imported.error(), kUnreadable);
  find_inertial_delay(arguments.drive, imported->notes);
  if (arguments.json) {
    Json json = {{"drive", arguments.drive},
                 {"packets", imported->packets},
                 {"channels", channels_json(*imported)},
                 {"notes", Json::array()}};
    for (const Error& note : imported->notes) json["notes"].push_back(note.message());
    std::cout << json_text(json) << "\n";
    return kDone;
  }
  std::cout << fmt::format("{}: {} packets\n", arguments.drive, imported->packets);
  for (const importers::LcmChannel& channel : imported->channels) print_channel(channel);
  for (const Error& note : imported->notes) std::cout << "  note: " << note.message() << "\n";
  return kDone;
}

int run_ford(const ImportArguments& arguments) {
  auto imported = importers::import_ford(arguments.source, arguments.drive);
  if (!imported) return print_error("infuse import ford", imported.error(), kUnreadable);
  find_inertial_delay(arguments.drive, imported->notes);
  if (arguments.json) {
    Json json = {{"drive", arguments.drive},   {"packets", imported->packets},
                 {"images", imported->images}, {"cameras", imported->cameras},
                 {"speeds", imported->speeds}, {"poses", imported->poses},
                 {"notes", Json::array()}};
    for (const Error& note : imported->notes) json["notes"].push_back(note.message());
    std::cout << json_text(json) << "\n";
    return kDone;
  }
  std::cout << fmt::format("{}: {} packets, {} images of {} cameras, {} speeds, {} poses\n",
                           arguments.drive, imported->packets, imported->images, imported->cameras,
                           imported->speeds, imported->poses);
  for (const importers::LcmChannel& channel : imported->channels) print_channel(channel);
  for (const Error& note : imported->notes) std::cout << "  note: " << note.message() << "\n";
  return kDone;
}

std::shared_ptr<LcmArguments> declare_lcm(CLI::App* app) {
  auto arguments = std::make_shared<LcmArguments>();
  app->add_option("FILE", arguments->files, "log of lcm-logger; several are read in this order")
      ->required();
  app->add_option("-o,--output", arguments->drive, "drive folder to create")
      ->required()
      ->type_name("DRIVE");
  app->add_flag("--json", arguments->json, "print the result as one JSON object");
  set_examples(*app, {"infuse import lcm lcmlog-2009-12-14.00 -o drive/",
                      "infuse import lcm lcmlog.00 lcmlog.01 -o drive/ --json"});
  return arguments;
}

/// Declares the arguments that all sources share.
std::shared_ptr<ImportArguments> declare(CLI::App* app, const char* source,
                                         const char* description) {
  auto arguments = std::make_shared<ImportArguments>();
  app->add_option(source, arguments->source, description)->required();
  app->add_option("-o,--output", arguments->drive, "drive folder to create")
      ->required()
      ->type_name("DRIVE");
  app->add_flag("--json", arguments->json, "print the result as one JSON object");
  return arguments;
}

}  // namespace

Command declare_import(CLI::App& infuse) {
  CLI::App* app = add_tool(infuse, *find_tool("import"));
  app->require_subcommand(1);
  CLI::App* kitti = app->add_subcommand("kitti", "KITTI's raw, odometry and object layouts");
  CLI::App* opencalib =
      app->add_subcommand("opencalib", "one scene of OpenCalib's lidar-to-camera data");
  CLI::App* rosbag = app->add_subcommand("rosbag", "recordings of ROS 2 (MCAP, SQLite) and ROS 1");
  const auto from_rosbag = declare_rosbag(rosbag);
  CLI::App* lcm = app->add_subcommand("lcm", "packets of lidars in logs of LCM");
  const auto from_lcm = declare_lcm(lcm);
  const auto from_kitti = declare(kitti, "DIR", "folder of the data set");
  CLI::App* ford = app->add_subcommand("ford", "a trial of the Ford Campus data set");
  const auto from_ford = declare(ford, "DIR", "folder of the trial, with LCM, IMAGES and SCANS");
  set_examples(*ford, {"infuse import ford dataset-2/ -o drive/",
                       "infuse import ford dataset-2/ -o drive/ --json"});
  const auto from_opencalib =
      declare(opencalib, "FILE", "NAME.calib.txt; NAME.pcd and NAME.png or .jpg are next to it");
  CLI::App* folder =
      app->add_subcommand("folder", "captures and images of your own, described by a TOML file");
  const auto from_folder =
      declare(folder, "FILE.toml", "description; the files it names are in its folder");
  set_examples(*folder, {"infuse import folder recording/folder.toml -o drive/",
                         "infuse import folder recording/folder.toml -o drive/ --json"});
  set_examples(*app, {"infuse import kitti 2011_09_26/2011_09_26_drive_0005_sync -o drive/",
                      "infuse import rosbag drive.mcap -o drive/"});
  set_examples(*kitti, {"infuse import kitti 2011_09_26/2011_09_26_drive_0005_sync -o drive/",
                        "infuse import kitti dataset/sequences/07 -o drive/ --json"});
  set_examples(*opencalib, {"infuse import opencalib scene/0.calib.txt -o drive/",
                            "infuse import opencalib scene/0.calib.txt -o drive/ --json"});
  return {app, [=] {
            if (rosbag->parsed()) return run_rosbag(*from_rosbag);
            if (lcm->parsed()) return run_lcm(*from_lcm);
            if (ford->parsed()) return run_ford(*from_ford);
            if (folder->parsed()) return run_folder(*from_folder);
            return kitti->parsed() ? run_kitti(*from_kitti) : run_opencalib(*from_opencalib);
          }};
}

}  // namespace infuse::daemon
