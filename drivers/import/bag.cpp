#include "drivers/import/bag.hpp"

#include <algorithm>
#include <map>

#include "drivers/mcap/mcap_reader.hpp"
#include "drivers/mcap/record_bytes.hpp"
#include "drivers/recording/mapped_file.hpp"
#include "drivers/ros/schemas.hpp"
#include "drivers/rosbag/bag_reader.hpp"
#include "drivers/rosbag/database_reader.hpp"

namespace infuse::importers {
namespace {

/// True for messages of ROS 2; some recorders do not state it.
bool is_cdr(const std::string& encoding) { return encoding == "cdr" || encoding.empty(); }

/// Messages in encodings that are not read, by encoding.
class OtherEncodings {
 public:
  /// True if messages in this encoding are not read; counts them.
  bool skip(const std::string& encoding) {
    const bool other = !is_cdr(encoding) && encoding != "ros1";
    if (other) ++counts_[encoding];
    return other;
  }
  void append_notes(std::vector<Error>& notes) const {
    for (const auto& [encoding, count] : counts_) {
      notes.push_back(
          {std::to_string(count) + " messages in the encoding '" + encoding + "' are skipped", "",
           "known: cdr, ros1"});
    }
  }

 private:
  std::map<std::string, size_t> counts_;
};

class McapBag : public Bag {
 public:
  McapBag(recording::MappedFile file, mcap::McapReader reader)
      : file_(std::move(file)), reader_(std::move(reader)) {}

  bool next(BagMessage& message) override {
    mcap::Message read;
    while (reader_.next(read)) {
      if (others_.skip(read.channel->encoding)) continue;
      std::string& type = types_[read.channel];
      if (type.empty()) type = ros::normalise_type(read.channel->schema.name);
      message = {read.channel->topic, type,
                 is_cdr(read.channel->encoding) ? ros::Encoding::kCdr : ros::Encoding::kRos1,
                 read.log_time, read.data};
      return true;
    }
    return false;
  }

  std::map<std::string, std::map<std::string, std::string>> metadata() const override {
    return reader_.metadata();
  }

  void append_notes(std::vector<Error>& notes) const override {
    reader_.append_notes(notes);
    others_.append_notes(notes);
  }

 private:
  recording::MappedFile file_;
  mcap::McapReader reader_;
  std::map<const mcap::Channel*, std::string> types_;
  OtherEncodings others_;
};

class Ros1Bag : public Bag {
 public:
  Ros1Bag(recording::MappedFile file, rosbag::BagReader reader)
      : file_(std::move(file)), reader_(std::move(reader)) {}

  bool next(BagMessage& message) override {
    rosbag::BagMessage read;
    if (!reader_.next(read)) return false;
    std::string& type = types_[read.connection];
    if (type.empty()) type = ros::normalise_type(read.connection->type);
    message = {read.connection->topic, type, ros::Encoding::kRos1, read.time, read.data};
    return true;
  }

  void append_notes(std::vector<Error>& notes) const override { reader_.append_notes(notes); }

 private:
  recording::MappedFile file_;
  rosbag::BagReader reader_;
  std::map<const rosbag::Connection*, std::string> types_;
};

class DatabaseBag : public Bag {
 public:
  explicit DatabaseBag(rosbag::DatabaseReader reader) : reader_(std::move(reader)) {}

  bool next(BagMessage& message) override {
    rosbag::DatabaseMessage read;
    while (reader_.next(read)) {
      if (others_.skip(read.topic->encoding)) continue;
      std::string& type = types_[read.topic];
      if (type.empty()) type = ros::normalise_type(read.topic->type);
      const bool cdr = is_cdr(read.topic->encoding);
      message = {read.topic->name, type, cdr ? ros::Encoding::kCdr : ros::Encoding::kRos1,
                 read.time, read.data};
      return true;
    }
    return false;
  }

  void append_notes(std::vector<Error>& notes) const override {
    reader_.append_notes(notes);
    others_.append_notes(notes);
  }

 private:
  rosbag::DatabaseReader reader_;
  std::map<const rosbag::DatabaseTopic*, std::string> types_;
  OtherEncodings others_;
};

}  // namespace

Stamp stamp_of(const ros::Header& header, Stamp log_time) {
  const Stamp stamp = header.stamp.stamp();
  return stamp == Stamp() ? log_time : stamp;
}

Result<std::unique_ptr<Bag>> open_bag(const std::filesystem::path& path) {
  auto file = recording::MappedFile::open(path);
  if (!file) return tl::unexpected(file.error());
  const std::span bytes(reinterpret_cast<const uint8_t*>(file->bytes().data()),
                        file->bytes().size());
  if (rosbag::BagReader::is_bag(bytes)) {
    auto reader = rosbag::BagReader::open(bytes, path.string());
    if (!reader) return tl::unexpected(reader.error());
    return std::make_unique<Ros1Bag>(std::move(*file), std::move(*reader));
  }
  if (rosbag::DatabaseReader::is_database(bytes)) {
    auto reader = rosbag::DatabaseReader::open(path);
    if (!reader) return tl::unexpected(reader.error());
    return std::make_unique<DatabaseBag>(std::move(*reader));
  }
  const size_t magic = std::min(bytes.size(), mcap::kMagic.size());
  if (!std::ranges::equal(bytes.first(magic), mcap::kMagic)) {
    return fail("is not a known kind of recording", path.string(),
                "known: MCAP, SQLite of rosbag2, bags of ROS 1 (format 2.0)");
  }
  auto reader = mcap::McapReader::open(bytes, path.string());
  if (!reader) return tl::unexpected(reader.error());
  return std::make_unique<McapBag>(std::move(*file), std::move(*reader));
}

Result<std::vector<std::filesystem::path>> list_bags(
    const std::vector<std::filesystem::path>& paths) {
  std::vector<std::filesystem::path> files;
  for (const auto& path : paths) {
    std::error_code failed;
    if (!std::filesystem::is_directory(path, failed)) {
      files.push_back(path);
      continue;
    }
    std::vector<std::filesystem::path> parts;
    for (const auto& entry : std::filesystem::directory_iterator(path, failed)) {
      const auto extension = entry.path().extension();
      if (extension == ".mcap" || extension == ".db3" || extension == ".bag")
        parts.push_back(entry.path());
    }
    if (parts.empty()) {
      return fail("has no recording", path.string(),
                  "expected a folder of rosbag2, with .mcap or .db3 files");
    }
    std::ranges::sort(parts, {}, [](const std::filesystem::path& part) {
      return std::pair(part.native().size(), part.native());
    });
    files.insert(files.end(), parts.begin(), parts.end());
  }
  return files;
}

}  // namespace infuse::importers
