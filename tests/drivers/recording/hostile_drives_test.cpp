// Two thousand folders from elsewhere: damaged descriptions, and pipes, devices, folders and links
// in the place of files. Each is read or refused, at once.

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <map>
#include <random>
#include <string>

#include "drivers/recording/drive_source.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::recording {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDescription =
    "name = \"elsewhere\"\n[[lidar]]\nname = \"top\"\npackets = \"lidar.pcap\"\n"
    "T_vehicle_lidar = [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]\n"
    "[[camera]]\nname = \"front\"\nimages = \"front\"\nlidar = \"top\"\nwidth = 8\nheight = 8\n"
    "fx = 8\nfy = 8\ncx = 4\ncy = 4\nT_camera_lidar = [0,-1,0,0, 0,0,-1,0, 1,0,0,0, 0,0,0,1]\n"
    "[speed]\nfile = \"speed.csv\"\n[imu]\nfile = \"imu.csv\"\n[gnss]\nfile = \"gnss.csv\"\n";

constexpr const char* kFiles[] = {"drive.toml", "lidar.pcap", "front/times.csv", "front/000000.png",
                                  "front",      "speed.csv",  "imu.csv",         "gnss.csv"};

const std::map<std::string, std::string>& texts() {
  static const std::map<std::string, std::string> all = {
      {"drive.toml", kDescription},
      {"lidar.pcap", std::string("\xd4\xc3\xb2\xa1\x02\0\x04\0", 8) + std::string(12, '\0') +
                         std::string("\x01\0\0\0", 4)},
      {"front/times.csv", "stamp_ns\n1000000000\n"},
      {"front/000000.png", "\x89PNG"},
      {"speed.csv", "stamp_ns,speed\n1000000000,3\n"},
      {"imu.csv", "stamp_ns,wx,wy,wz,ax,ay,az\n1000000000,0,0,0,0,0,9.8\n"},
      {"gnss.csv", "stamp_ns,latitude_deg,longitude_deg\n1000000000,48,11\n"}};
  return all;
}

/// Writes the files of `name`, a file or a folder.
void restore(const ScratchFolder& folder, const std::string& name) {
  fs::remove_all(folder / name);
  for (const auto& [file, text] : texts()) {
    if (file.starts_with(name)) folder.write(file, text);
  }
}

void damage(std::string& text, std::mt19937& random) {
  for (auto changes = 1 + random() % 6; changes > 0 && !text.empty(); --changes) {
    const size_t at = random() % text.size();
    if (random() % 4 == 0) text.insert(at, text.substr(random() % text.size(), random() % 60));
    text[at % text.size()] = static_cast<char>(random());
  }
}

void replace_by_something(const fs::path& path, uint32_t what) {
  fs::remove_all(path);
  switch (what % 6) {
    case 0:
      ::mkfifo(path.c_str(), 0600);
      break;
    case 1:
      fs::create_symlink("/dev/zero", path);
      break;
    case 2:
      fs::create_symlink("/etc/passwd", path);
      break;
    case 3:
      fs::create_symlink(path.filename(), path);
      break;  // to itself
    case 4:
      fs::create_directory(path);
      break;
    default:
      break;  // missing
  }
}

/// Reads a drive as far as it can be; returns the number of events.
int read_events(const fs::path& folder, int& opened) {
  const auto drive = Drive::open(folder);
  if (!drive) return 0;
  auto source = DriveSource::open(*drive);
  if (!source) return 0;
  ++opened;
  int events = 0;
  DriveEvent event;
  while (events < 1000 && source->next(event)) ++events;
  return events;
}

TEST(HostileDrives, AreReadOrRefused) {
  const ScratchFolder folder;
  std::mt19937 random(1);
  int opened = 0, events = 0;
  for (const char* name : kFiles) restore(folder, name);
  for (int round = 0; round < 2000; ++round) {
    const char* name = kFiles[random() % std::size(kFiles)];
    const bool damaged = random() % 2 == 0 && fs::is_regular_file(folder / name);
    if (round > 0 && damaged) {
      std::string text = texts().at(name);
      damage(text, random);
      folder.write(name, text);
    } else if (round > 0) {
      replace_by_something(folder / name, static_cast<uint32_t>(random()));
    }
    events += read_events(folder.path(), opened);
    restore(folder, name);
    if (round == 0) {
      ASSERT_GE(events, 4);  // as made it is a drive
    }
  }
  EXPECT_GT(opened, 100);
  EXPECT_LT(opened, 1900);
}

}  // namespace
}  // namespace infuse::recording
