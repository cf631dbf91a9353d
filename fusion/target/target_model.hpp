#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fusion/target/target_view.hpp"

namespace infuse::target {

/// Standard deviations of the errors that all views share.
struct SharedErrors {
  /// m; range bias that all beams share, of each beam, and between the darkest and the brightest
  /// returns. Manuals state ± 2 cm (HDL-32E, HDL-64E, Pandar40P) to ± 3 cm (VLP-16, VLP-32C: 1.7 cm
  /// if any value within is as likely).
  double range_accuracy = 0.02;
  /// m; distance from the lidar's axis of where its beams cross, as far as the points leave it out:
  /// 42 mm of a VLP-16 (vertical corrections of ± 11.2 mm at ± 15°), 16 to 28 mm of an Ouster.
  double beam_origin = 0.03;
  /// m; bow and twist of the board, half a board from its middle.
  double flatness = 0.002;
  /// Relative error of distances by the camera: focal length and the squares' size.
  double scale = 0.003;

  /// Returns what is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// A board's place relative to that of its corners: displacement of its middle along the normal (m)
/// and slopes along its two sides (rad).
using BoardShift = Eigen::Vector3d;
/// Covariance of a board's shift.
using ShiftCovariance = Eigen::Matrix3d;

/// Normal equations of the distances of one view's returns from the board, at unit range noise.
struct ViewEquations {
  Eigen::MatrixXd shared;                          ///< JᵀJ of the shared parameters
  Eigen::Matrix<double, Eigen::Dynamic, 3> cross;  ///< of the shared ones and the board's shift
  ShiftCovariance own = ShiftCovariance::Zero();   ///< of the board's shift
  Eigen::VectorXd shared_gradient;                 ///< −Jᵀr
  BoardShift own_gradient = BoardShift::Zero();    ///< −Jᵀr
  double squares = 0;                              ///< rᵀr
  double returns = 0;                              ///< number of residuals
};

/// View with its board's shift eliminated, given the covariance of the shift.
struct ReducedView {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  double chi_squared = 0;      ///< at zero
  double log_determinant = 0;  ///< of what was eliminated, relative to the prior
};

/// Eliminates the board's shift, a Gaussian around zero.
ReducedView reduce_view(const ViewEquations& view, const ShiftCovariance& shift_covariance,
                        double noise);

/// What the distance of a return from its board depends on beside its own noise, linearised:
/// parameters are a left perturbation of T_refcam_lidar (6), the range bias of all beams, the range
/// bias by reflectivity, the scale of the camera's distances, the board's bow along x, twist and
/// bow along y, where the beams cross, a shift of all boards alike, and the range bias of each beam
/// that met a board. Each view has a shift of its board besides, by noise of its corners and by
/// what the model does not know.
class TargetModel {
 public:
  /// Indices of the parameters beside the pose.
  enum : Eigen::Index {
    kCommon = 6,      ///< range bias of all beams, m
    kContrast = 7,    ///< brightest minus darkest, m
    kScale = 8,       ///< relative
    kBow = 9,         ///< three of them, m
    kOrigin = 12,     ///< distance of the beams' crossing from the axis, m
    kShift = 13,      ///< shift of all boards alike, a BoardShift
    kFirstBeam = 16,  ///< range biases of the beams, m
  };

  /// Keeps a reference to the views.
  explicit TargetModel(std::span<const TargetView> views);

  /// Number of shared parameters.
  Eigen::Index size() const { return kFirstBeam + beams_; }

  /// Inverse covariance of the shared parameters before any view is seen.
  Eigen::MatrixXd prior_information(const SharedErrors& errors) const;

  /// Linearises the distances of one view's returns at a pose.
  ViewEquations linearise(size_t view, const Eigen::Isometry3d& T_refcam_lidar) const;

  /// Covariance of the board's shift by that of its pose.
  static ShiftCovariance shift_covariance(const TargetView& view);

 private:
  /// Reflectivity relative to the boards' darkest and brightest returns: −½ … ½.
  double contrast(double reflectivity) const;

  std::span<const TargetView> views_;
  std::vector<Eigen::Index> beam_of_ring_;
  Eigen::Index beams_ = 0;
  double dark_ = 0, bright_ = 0;  // reflectivities of the boards
};

}  // namespace infuse::target
