#include "drivers/import/bag_topics.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/import/bag.hpp"
#include "drivers/import/bag_packets.hpp"
#include "drivers/makers/makers.hpp"
#include "drivers/ros/serialisation.hpp"

namespace infuse::importers {
namespace {

constexpr size_t kMaxBagTopics = 10'000;
constexpr size_t kMaxLags = 1'000'000;  // of a topic: the median is that of the first

struct HeaderOnly {
  ros::Header header;
  void fields(auto& archive) { archive(header); }
};

/// Finds out about a recording's topics.
class Surveyor {
 public:
  void add(const BagMessage& message) {
    const auto found = topics_.find(message.topic);
    if (found == topics_.end() && topics_.size() >= kMaxBagTopics) return;
    auto& entry = found == topics_.end() ? topics_[std::string(message.topic)] : found->second;
    BagTopic& topic = entry.first;  // clang 14 captures no structured bindings
    std::vector<double>& lags = entry.second;
    if (topic.messages++ == 0) {
      topic.name = message.topic;
      topic.type = message.type;
    }
    if (topic.type == ros::TfMessage::kName) {
      with<ros::TfMessage>(message, topic, [&](const auto& tf) { survey_.frames.add(tf); });
    } else if (topic.type == ros::CameraInfo::kName) {
      with<ros::CameraInfo>(message, topic, [&](const auto& info) {
        survey_.camera_infos.try_emplace(topic.name, info);
      });
    } else if (topic.type == ros::Imu::kName) {
      with<ros::Imu>(message, topic, [&](const auto& imu) {
        const auto& [wx, wy, wz] = imu.angular_velocity;
        const auto& [ax, ay, az] = imu.linear_acceleration;
        topic.is_measured = topic.is_measured || std::isfinite(wx + wy + wz + ax + ay + az);
      });
    } else if (topic.type == ros::TwistStamped::kName) {
      with<ros::TwistStamped>(message, topic,
                              [&](const auto& twist) { note_motion(twist.twist, topic); });
    } else if (topic.type == ros::Odometry::kName) {
      with<ros::Odometry>(message, topic,
                          [&](const auto& pose) { note_motion(pose.twist, topic); });
    } else if (topic.type == ros::TwistWithCovarianceStamped::kName) {
      with<ros::TwistWithCovarianceStamped>(
          message, topic, [&](const auto& twist) { note_motion(twist.twist, topic); });
    }
    if (holds_packets(topic.type)) note_packets(message, topic);
    if (has_header(topic.type)) {
      with<HeaderOnly>(message, topic, [&](const HeaderOnly& only) {
        note_header(only.header, message.log_time, topic, lags);
      });
    }
  }

  BagSurvey finish() {
    for (auto& [name, entry] : topics_) {
      auto& [topic, lags] = entry;
      if (!lags.empty()) {
        std::ranges::sort(lags);
        topic.lag = {lags.size(), lags[lags.size() / 2], lags.front(), lags.back()};
      }
      survey_.topics.push_back(topic);
    }
    return std::move(survey_);
  }

  BagSurvey& survey() { return survey_; }

 private:
  static bool has_header(const std::string& type) {
    const bool of_packets =
        holds_packets(type) && !type.ends_with("/PacketMsg") && !type.ends_with("/rslidarPacket");
    return of_packets || type == ros::PointCloud2::kName || type == ros::Image::kName ||
           type == ros::CompressedImage::kName || type == ros::Imu::kName ||
           type == ros::NavSatFix::kName || type == ros::TwistStamped::kName ||
           type == ros::TwistWithCovarianceStamped::kName || type == ros::Odometry::kName;
  }

  template <class T, class OnMessage>
  static void with(const BagMessage& message, BagTopic& topic, OnMessage on_message) {
    if (const auto read = ros::decode<T>(message.data, message.encoding)) {
      on_message(*read);
    } else {
      ++topic.unreadable;
    }
  }

  static void note_packets(const BagMessage& message, BagTopic& topic) {
    if (topic.has_data_packets) return;
    const auto note = [&](Stamp, std::span<const uint8_t> payload) {
      const auto kind = makers::classify(payload).packet_class;
      topic.has_data_packets |=
          kind == lidar::PacketClass::kData ||
          (kind == lidar::PacketClass::kOther && topic.type == ros::VelodyneScan::kName);
    };
    if (!read_packets(message, note)) ++topic.unreadable;
  }

  static void note_motion(const ros::Twist& twist, BagTopic& topic) {
    const auto& [wx, wy, wz] = twist.angular;
    topic.is_measured = topic.is_measured || twist.linear.x != 0 || wz != 0;
    topic.has_x = topic.has_x || twist.linear.x != 0;
    topic.has_y = topic.has_y || twist.linear.y != 0;
    topic.has_turns = topic.has_turns || wx != 0 || wy != 0 || wz != 0;
  }

  static void note_header(const ros::Header& header, Stamp log_time, BagTopic& topic,
                          std::vector<double>& lags) {
    if (topic.frame.empty()) topic.frame = frame_name(header.frame_id);
    const Stamp stamp = header.stamp.stamp();
    if (stamp == Stamp()) {
      ++topic.stampless;
    } else if (lags.size() < kMaxLags) {
      lags.push_back(to_seconds(log_time - stamp));
    }
  }

  BagSurvey survey_;
  std::map<std::string, std::pair<BagTopic, std::vector<double>>, std::less<>> topics_;
};

/// Parent and last part of a topic's name: "/camera/left" and "image_raw".
std::pair<std::string, std::string> split_topic(const std::string& topic) {
  const size_t slash = topic.rfind('/');
  if (slash == std::string::npos) return {"", topic};
  return {topic.substr(0, slash), topic.substr(slash + 1)};
}

/// A name for the sensor of a topic: the last part of its namespace, "left" of
/// "/camera/left/image_raw", or the topic's own where it has none.
std::string sensor_name(const std::string& space, const std::string& topic) {
  std::string name = split_topic(space).second;
  if (name.empty()) name = split_topic(topic).second;
  for (char& c : name) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
    if (!plain) c = '_';
  }
  return name.empty() ? "sensor" : name;
}

template <class Sensor>
std::string unique_name(const std::string& name, const std::vector<Sensor>& sensors) {
  std::string unique = name;
  for (int k = 2; std::ranges::find(sensors, unique, &Sensor::name) != sensors.end(); ++k)
    unique = name + "_" + std::to_string(k);
  return unique;
}

tl::unexpected<Error> ambiguous(const std::string& kind, const std::vector<std::string>& topics) {
  std::string names;
  for (const std::string& topic : topics) names += (names.empty() ? "" : ", ") + topic;
  return fail("there are several topics of " + kind + ": " + names, "",
              "choose with --topic, which may be repeated");
}

/// Whether a topic has velocities to the east and north, beside these fixes.
bool is_over_ground(const BagTopic& topic, const std::string& fixes) {
  if (fixes.empty()) return false;
  const auto [space, name] = split_topic(topic.name);
  const bool of_type = topic.type == ros::TwistStamped::kName ||
                       topic.type == ros::TwistWithCovarianceStamped::kName;
  return of_type && space == split_topic(fixes).first && name.find("vel") != std::string::npos &&
         !topic.has_turns && (topic.has_y || !topic.has_x) && topic.unreadable < topic.messages;
}

/// Whether infuse wrote the topic, as what it made of the others: no sensor measured it.
bool is_estimate(const BagSurvey& survey, const BagTopic& topic) {
  const auto of_infuse = survey.metadata.find("infuse");
  return of_infuse != survey.metadata.end() && of_infuse->second.contains("estimate " + topic.name);
}

/// The topics that `is_kind` accepts and that are not unreadable, and only the wanted ones if there
/// are any among them.
template <class IsKind>
std::vector<const BagTopic*> candidates(const BagSurvey& survey,
                                        const std::set<std::string>& wanted, IsKind is_kind,
                                        BagSelection& selection) {
  std::vector<const BagTopic*> all;
  for (const BagTopic& topic : survey.topics) {
    if (!is_kind(topic)) continue;
    if (topic.unreadable == topic.messages) {
      selection.reasons[topic.name] = "its messages are not of its type";
    } else if (is_estimate(survey, topic) && !wanted.contains(topic.name)) {
      selection.reasons[topic.name] = "infuse estimated it from the other topics";
    } else {
      all.push_back(&topic);
    }
  }
  const auto is_wanted = [&](const BagTopic* topic) { return wanted.contains(topic->name); };
  if (std::ranges::any_of(all, is_wanted)) {
    std::erase_if(all, [&](const BagTopic* topic) {
      if (!is_wanted(topic)) selection.reasons[topic->name] = "--topic names another one";
      return !is_wanted(topic);
    });
  }
  return all;
}

/// Accepts topics of one of these types.
auto of_types(std::vector<std::string_view> types) {
  return [types = std::move(types)](const BagTopic& topic) {
    return std::ranges::find(types, topic.type) != types.end();
  };
}

Result<std::string> select_one(const BagSurvey& survey, const std::set<std::string>& wanted,
                               std::vector<std::string_view> types, const std::string& kind,
                               BagSelection& selection) {
  auto all = candidates(survey, wanted, of_types(std::move(types)), selection);
  std::erase_if(all, [&](const BagTopic* topic) {
    const bool over_ground = is_over_ground(*topic, selection.gnss);
    if (over_ground && topic->name != selection.velocity)
      selection.reasons[topic->name] = selection.velocity + " is the velocity of the fixes";
    return over_ground;
  });
  std::erase_if(all, [&](const BagTopic* topic) {
    const bool empty = topic->type != ros::NavSatFix::kName && !topic->is_measured &&
                       !wanted.contains(topic->name);
    if (empty) {
      selection.reasons[topic->name] =
          topic->type == ros::Imu::kName ? "its samples are not complete" : "its twists are zero";
    }
    return empty;
  });
  if (all.empty()) return std::string();
  if (all.size() == 1) return all.front()->name;
  std::vector<std::string> names;
  for (const BagTopic* topic : all) names.push_back(topic->name);
  return ambiguous(kind, names);
}

/// How much of what the lidar measured a topic has: packets, clouds as measured, other clouds.
int rank_of(const BagTopic& topic) {
  if (topic.has_data_packets) return 0;
  return topic.name.ends_with("_raw") ? 1 : 2;
}

/// The first topic of a namespace that `is_kind` accepts; empty: there is none.
template <class IsKind>
std::string topic_beside(const BagSurvey& survey, const std::string& space, IsKind is_kind) {
  for (const BagTopic& topic : survey.topics) {
    if (split_topic(topic.name).first == space && is_kind(topic)) return topic.name;
  }
  return "";
}

bool is_lidar(const BagTopic& topic) {
  return topic.has_data_packets || topic.type == ros::PointCloud2::kName ||
         (holds_packets(topic.type) && topic.unreadable == topic.messages);
}

/// Packets of information or of the inertial unit, in a topic of their own.
bool is_beside_packets(const BagTopic& topic) {
  return (holds_packets(topic.type) && !topic.has_data_packets) ||
         (topic.type == ros::UInt8MultiArray::kName && topic.name.ends_with("/position_packets"));
}

bool is_metadata(const BagTopic& topic) {
  return topic.type == ros::String::kName && topic.name.ends_with("/metadata");
}

/// Frame of a lidar's topic; of packets without headers that of a cloud beside them; else the
/// namespace, which is no frame.
std::string group_of(const BagSurvey& survey, const BagTopic& topic) {
  if (!topic.frame.empty() || !topic.has_data_packets) return topic.frame;
  const std::string space = split_topic(topic.name).first;
  const std::string cloud = topic_beside(survey, space, [](const BagTopic& each) {
    return each.type == ros::PointCloud2::kName && !each.frame.empty();
  });
  const BagTopic* found = survey.find(cloud);
  return found != nullptr ? found->frame : space;
}

Result<void> select_lidars(const BagSurvey& survey, const std::set<std::string>& wanted,
                           BagSelection& selection) {
  std::map<std::string, std::vector<const BagTopic*>> by_frame;
  for (const BagTopic* topic : candidates(survey, wanted, is_lidar, selection))
    by_frame[group_of(survey, *topic)].push_back(topic);
  for (auto& [frame, topics] : by_frame) {
    std::ranges::stable_sort(topics, {}, [](const BagTopic* topic) { return rank_of(*topic); });
    const BagTopic& best = *topics.front();
    if (topics.size() > 1 && rank_of(best) == rank_of(*topics[1])) {
      std::vector<std::string> names;
      for (const BagTopic* topic : topics) names.push_back(topic->name);
      return ambiguous("the lidar '" + frame + "'", names);
    }
    for (size_t k = 1; k < topics.size(); ++k)
      selection.reasons[topics[k]->name] = best.name + " has what the lidar measured";
    const std::string space = split_topic(best.name).first;
    BagLidar lidar{.name = unique_name(sensor_name(space, best.name), selection.lidars),
                   .topic = best.name,
                   .frame = frame,
                   .has_packets = best.has_data_packets};
    if (lidar.has_packets) {
      lidar.positions = topic_beside(survey, space, is_beside_packets);
      lidar.metadata = topic_beside(survey, space, is_metadata);
    }
    selection.lidars.push_back(std::move(lidar));
  }
  return {};
}

Result<void> select_cameras(const BagSurvey& survey, const std::set<std::string>& wanted,
                            BagSelection& selection) {
  std::map<std::string, std::vector<BagCamera>> by_space;
  for (const BagTopic* topic : candidates(
           survey, wanted, of_types({ros::Image::kName, ros::CompressedImage::kName}), selection)) {
    BagCamera camera{.topic = topic->name, .frame = topic->frame};
    camera.compressed = topic->type == ros::CompressedImage::kName;
    const auto [parent, last] = split_topic(topic->name);
    // image_transport: "X/compressed" is the image X.
    const bool is_transport = camera.compressed && last == "compressed";
    const auto [space, image] = is_transport ? split_topic(parent) : std::pair(parent, last);
    camera.rectified = image.starts_with("image_rect");
    camera.name = sensor_name(space, topic->name);
    const auto info = survey.camera_infos.find(space + "/camera_info");
    if (info == survey.camera_infos.end()) {
      selection.reasons[topic->name] = "there is no " + space + "/camera_info";
      continue;
    }
    camera.info = info->second;
    by_space[space].push_back(camera);
  }
  for (auto& [space, cameras] : by_space) {
    // The same image twice: as it was, and compressed.
    std::ranges::stable_sort(cameras, {}, &BagCamera::compressed);
    while (cameras.size() > 1 && cameras.back().topic == cameras.front().topic + "/compressed") {
      selection.reasons[cameras.back().topic] = cameras.front().topic + " is not compressed";
      cameras.pop_back();
    }
    if (cameras.size() > 1) {
      std::vector<std::string> names;
      for (const BagCamera& camera : cameras) names.push_back(camera.topic);
      return ambiguous("the camera " + space, names);
    }
    cameras.front().name = unique_name(cameras.front().name, selection.cameras);
    selection.cameras.push_back(cameras.front());
  }
  return {};
}

}  // namespace

const BagTopic* BagSurvey::find(const std::string& name) const {
  const auto found = std::ranges::find(topics, name, &BagTopic::name);
  return found == topics.end() ? nullptr : &*found;
}

Result<BagSurvey> survey_bags(const std::vector<std::filesystem::path>& files) {
  Surveyor surveyor;
  for (const auto& file : files) {
    const auto bag = open_bag(file);
    if (!bag) return tl::unexpected(bag.error());
    BagMessage message;
    while ((*bag)->next(message)) surveyor.add(message);
    (*bag)->append_notes(surveyor.survey().notes);
    auto metadata = (*bag)->metadata();
    surveyor.survey().metadata.merge(metadata);
  }
  return surveyor.finish();
}

std::string velocity_beside(const BagSurvey& survey, const std::string& fixes) {
  for (const BagTopic& topic : survey.topics) {
    if (is_over_ground(topic, fixes)) return topic.name;
  }
  return "";
}

Result<BagSelection> select_topics(const BagSurvey& survey, const std::set<std::string>& wanted) {
  for (const std::string& name : wanted) {
    if (survey.find(name) == nullptr) {
      std::string names;
      for (const BagTopic& topic : survey.topics) names += (names.empty() ? "" : ", ") + topic.name;
      return fail("there is no topic '" + name + "'", "", "topics: " + names);
    }
  }
  BagSelection selection;
  const auto gnss = select_one(survey, wanted, {ros::NavSatFix::kName}, "GNSS fixes", selection);
  if (!gnss) return tl::unexpected(gnss.error());
  selection.gnss = *gnss;
  selection.velocity = velocity_beside(survey, *gnss);
  if (auto done = select_lidars(survey, wanted, selection); !done)
    return tl::unexpected(done.error());
  if (auto done = select_cameras(survey, wanted, selection); !done)
    return tl::unexpected(done.error());
  const auto speed = select_one(
      survey, wanted,
      {ros::TwistStamped::kName, ros::TwistWithCovarianceStamped::kName, ros::Odometry::kName},
      "the vehicle's speed", selection);
  if (!speed) return tl::unexpected(speed.error());
  const auto imu = select_one(survey, wanted, {ros::Imu::kName}, "an inertial unit", selection);
  if (!imu) return tl::unexpected(imu.error());
  selection.speed = *speed;
  selection.imu = *imu;
  return selection;
}

}  // namespace infuse::importers
