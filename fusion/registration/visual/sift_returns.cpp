#include "fusion/registration/visual/sift_returns.hpp"

#include <opencv2/features2d.hpp>

#include "fusion/registration/visual/grey_matrix.hpp"
#include "fusion/registration/visual/visible_returns.hpp"

namespace infuse::registration {
Result<SiftReturns> find_sift_returns(const CameraLidarScan& scan, double radius) {
  SiftReturns found;
  std::vector<cv::Mat> descriptors;
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create();
  for (size_t index = 0; index < scan.images.size(); ++index) {
    const auto& [frame, camera] = scan.images[index];
    const CameraIntrinsics& k = camera.intrinsics;
    if (frame.format != PixelFormat::kGrey8 && frame.format != PixelFormat::kBgr8) {
      return fail("image of camera " + camera.name + " is a Bayer mosaic: convert it first");
    }
    if (frame.width != k.width || frame.height != k.height || frame.width < 1 || frame.height < 1) {
      return fail("image of camera " + camera.name + " is not of the size in its intrinsics");
    }
    const VisibleReturns visible(scan.sweep.points, camera);
    const cv::Mat image = grey_matrix(frame);
    std::vector<cv::KeyPoint> keypoints, tied;
    sift->detect(image, keypoints);
    for (const cv::KeyPoint& keypoint : keypoints) {
      // OpenCV repeats a keypoint for every orientation; the first one stands for it.
      if (!tied.empty() && tied.back().pt == keypoint.pt) continue;
      const int32_t i = visible.nearest(keypoint.pt.x, keypoint.pt.y, radius);
      if (i < 0) continue;
      tied.push_back(keypoint);
      found.returns.push_back(static_cast<uint32_t>(i));
      found.camera.push_back(static_cast<uint32_t>(index));
      found.u.push_back(keypoint.pt.x);
      found.v.push_back(keypoint.pt.y);
    }
    if (!tied.empty()) sift->compute(image, tied, descriptors.emplace_back());
  }
  found.descriptors.resize(128, static_cast<Eigen::Index>(found.size()));
  Eigen::Index column = 0;
  for (const cv::Mat& block : descriptors) {
    for (int row = 0; row < block.rows; ++row) {
      found.descriptors.col(column++) =
          Eigen::Map<const Eigen::VectorXf>(block.ptr<float>(row), 128).normalized();
    }
  }
  return found;
}

}  // namespace infuse::registration
