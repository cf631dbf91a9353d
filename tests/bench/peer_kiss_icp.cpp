#include "tests/bench/peer_kiss_icp.hpp"

#include <kiss_icp/pipeline/KissICP.hpp>

namespace infuse::bench {
namespace {

kiss_icp::pipeline::KISSConfig one_thread(bool deskew) {
  kiss_icp::pipeline::KISSConfig config;
  config.max_num_threads = 1;
  config.deskew = deskew;
  return config;
}

}  // namespace

struct PeerKissIcp::State {
  explicit State(bool deskew) : odometry(one_thread(deskew)) {}

  kiss_icp::pipeline::KissICP odometry;
  std::vector<Eigen::Vector3d> points;
  std::vector<double> times;
};

PeerKissIcp::PeerKissIcp(bool deskew) : state_(std::make_unique<State>(deskew)) {}
PeerKissIcp::~PeerKissIcp() = default;

void PeerKissIcp::set_points(const float* x, const float* y, const float* z, const int32_t* time_ns,
                             size_t size) {
  state_->points.resize(size);
  state_->times.resize(size);
  for (size_t i = 0; i < size; ++i) {
    state_->points[i] = Eigen::Vector3d(x[i], y[i], z[i]);
    state_->times[i] = 1e-9 * time_ns[i];
  }
}

void PeerKissIcp::add(double* T_first_lidar) {
  state_->odometry.RegisterFrame(state_->points, state_->times);
  Eigen::Map<Eigen::Matrix4d>(T_first_lidar).noalias() = state_->odometry.pose().matrix();
}

}  // namespace infuse::bench
