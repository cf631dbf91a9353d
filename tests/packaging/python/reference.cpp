// What the library returns to C++, for the tests of the Python module: reference FOLDER reads
// FOLDER/NAME.f32 and .f64 and writes FOLDER/NAME.out, doubles.

#include <fstream>
#include <iterator>

#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/makers/makers.hpp"
#include "drivers/recording/pcap_reader.hpp"
#include "fusion/dependence/bagged_lsmi.hpp"
#include "fusion/dependence/prepared_dependence.hpp"
#include "fusion/dependence/prepared_histogram.hpp"
#include "fusion/monitoring/calibration_monitor.hpp"
#include "fusion/motion/deskew.hpp"
#include "fusion/registration/gicp.hpp"
#include "fusion/registration/lidar_trajectory.hpp"
#include "fusion/streetmap/tracker.hpp"

namespace {

using namespace infuse;

std::string folder;

template <class T>
std::vector<T> read(const std::string& name) {
  std::ifstream file(folder + "/" + name, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

/// Values as doubles, in the order in which they are added.
class Out {
 public:
  explicit Out(const std::string& name) : file_(folder + "/" + name + ".out", std::ios::binary) {}
  void add(double value) { file_.write(reinterpret_cast<const char*>(&value), sizeof value); }
  template <class Values>
  void add_all(const Values& values) {
    for (const auto value : values) add(static_cast<double>(value));
  }
  void add_rows(const Eigen::MatrixXd& matrix) {
    for (Eigen::Index row = 0; row < matrix.rows(); ++row) add_all(matrix.row(row));
  }

 private:
  std::ofstream file_;
};

geometry::PointsView view(const std::vector<float>& xyz) {
  const size_t n = xyz.size() / 3;
  return {std::span(xyz).first(n), std::span(xyz).subspan(n, n), std::span(xyz).last(n)};
}

void align() {
  const auto target = read<float>("target.f32"), source = read<float>("source.f32");
  const auto to = registration::prepare_cloud(view(target));
  const auto from = registration::prepare_cloud(view(source));
  Out out("align");
  const auto add = [&](const registration::RegistrationResult& result) {
    out.add_rows(result.T_target_source.matrix());
    out.add_rows(result.covariance);
  };
  add(registration::gicp(to, from.cloud, Eigen::Isometry3d::Identity()));
  registration::Registration<registration::PointToPlaneFactor> plane;
  add(plane.align(to, from.cloud, Eigen::Isometry3d::Identity()));
}

void measure() {
  const auto x = read<float>("x.f32"), y = read<float>("y.f32");
  const auto n = static_cast<Eigen::Index>(x.size());
  Out out("measure");
  dependence::PreparedHistogram histogram(x, {});
  std::vector<float> gradient(x.size());
  for (int which = 0; which < 4; ++which) {
    out.add(
        histogram.value_and_gradient(static_cast<dependence::Measure>(which), y, gradient).value);
    out.add_all(gradient);
  }
  const Eigen::MatrixXd a = Eigen::Map<const Eigen::VectorXf>(x.data(), n).cast<double>();
  const Eigen::MatrixXd b = Eigen::Map<const Eigen::VectorXf>(y.data(), n).cast<double>();
  Eigen::MatrixXd by_sample;
  for (const auto fit :
       {dependence::FitMeasure::kSmi, dependence::FitMeasure::kQmi, dependence::FitMeasure::kSce}) {
    out.add(dependence::PreparedDependence(fit, a, {}).evaluate(b).value);
  }
  out.add(dependence::PreparedDependence(dependence::FitMeasure::kSmi, a, {})
              .evaluate(b, {}, &by_sample)
              .value);
  out.add_rows(by_sample);
  dependence::BagOptions bags{.bags = 5, .bag_size = 100, .fit = {}};
  out.add(dependence::BaggedLsmi(a, bags).evaluate(b, &by_sample).value);
  out.add_rows(by_sample);
}

/// Monitors a camera of 320 × 240 that sees another image with each sweep.
class Monitored {
 public:
  void add(const Sweep& sweep) {
    CameraFrame frame{.stamp = sweep.stamp, .width = 320, .height = 240};
    frame.format = PixelFormat::kGrey8;
    for (const uint8_t pixel : pixels_) {
      frame.pixels.push_back(static_cast<uint8_t>(pixel + 7 * count_));
    }
    ++count_;
    const Eigen::Vector3d turning(0, 0, 0.1), driving(8, 0, 0);  // of the lidar
    const Eigen::Isometry3d& T = monitor_.T_camera_lidar();
    const Eigen::Vector3d camera = T.inverse().translation();
    const auto report =
        monitor_.process(frame, monitoring::make_sweep_view(sweep),
                         {T.linear() * turning, T.linear() * (driving + turning.cross(camera))});
    out_.add(report.evaluated ? 1 : 0);
    out_.add(report.dependence);
    out_.add(report.verdict.evidence);
    out_.add_all(report.verdict.offset);
    out_.add_all(report.verdict.sigma);
  }

 private:
  static Eigen::Isometry3d pose() {
    Eigen::Isometry3d pose;
    const auto values = read<double>("camera.f64");
    pose.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
    return pose;
  }

  std::vector<uint8_t> pixels_ = read<uint8_t>("image.u8");
  monitoring::CalibrationMonitor monitor_{
      {.width = 320, .height = 240, .fx = 160, .fy = 160, .cx = 160, .cy = 120}, pose(), {}};
  int count_ = 0;
  Out out_{"monitor"};
};

/// Tracks a vehicle that drives 0.5 m ahead with each sweep.
class Tracked {
 public:
  Tracked() { tracker_.start({3, 4, 0.5}, Eigen::Vector3d(1, 1, 0.01).asDiagonal()); }
  void add(const Sweep& sweep) {
    tracker_.predict({0.5, 0, 0.01}, Eigen::Vector3d(1e-4, 1e-4, 1e-6).asDiagonal(),
                     Duration(100'000'000));
    tracker_.add_sweep({sweep, sweep.x, sweep.y, sweep.z}, nullptr);
    tracker_.update();
    const auto estimate = tracker_.estimate();
    for (const double value : {estimate.pose.x, estimate.pose.y, estimate.pose.yaw}) {
      out_.add(value);
    }
    out_.add_rows(estimate.covariance);
    out_.add(estimate.score);
    out_.add(estimate.p_value);
  }

 private:
  std::vector<std::byte> bytes_ = read<std::byte>("street.map");
  streetmap::SegmentMap map_ = streetmap::SegmentMap::open(bytes_, "street.map").value();
  streetmap::Tracker tracker_{map_};
  Out out_{"track"};
};

/// Every sweep of the capture; the odometry of them; the second, deskewed by a trajectory; what a
/// monitor and a tracker make of them.
void decode() {
  auto reader = recording::PcapReader::open(folder + "/capture.pcap");
  auto decoder = lidar::make_decoder({.model = makers::find_model("HDL-32E")});
  Out out("decode"), poses("odometry"), deskewed("deskew");
  registration::LidarTrajectory odometry(Eigen::Isometry3d::Identity());
  Monitored monitored;
  Tracked tracked;
  Sweep sweep;
  size_t sweeps = 0;
  const auto pull = [&] {
    for (; (*decoder)->pull(sweep); sweep.clear(), ++sweeps) {
      out.add(static_cast<double>(sweep.size()));
      for (const auto* field : {&sweep.x, &sweep.y, &sweep.z, &sweep.reflectivity}) {
        out.add_all(*field);
      }
      out.add_all(sweep.ring);
      out.add_all(sweep.time_offset_ns);
      poses.add_rows(odometry.add(sweep).T_map_vehicle.matrix());
      monitored.add(sweep);
      tracked.add(sweep);
      if (sweeps != 1) continue;
      geometry::Trajectory trajectory;
      for (int k = 0; k < 2; ++k) {
        geometry::StampedPose pose{.stamp = sweep.stamp + Duration(k * 150'000'000)};
        pose.T_odom_vehicle.translation().x() = 2 * k;
        trajectory.append(pose);
      }
      motion::DeskewedSweep moved;
      motion::Deskewer(Eigen::Isometry3d::Identity())
          .deskew(sweep, trajectory, sweep.stamp + sweep.span, moved);
      for (const auto* field : {&moved.x, &moved.y, &moved.z}) deskewed.add_all(*field);
    }
  };
  Datagram datagram;
  while (reader->next(datagram)) {
    (*decoder)->push(datagram);
    pull();
  }
  (*decoder)->finish();
  pull();
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) return 2;
  folder = arguments[1];
  align();
  measure();
  decode();
}
