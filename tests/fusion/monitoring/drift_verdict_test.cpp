#include "fusion/monitoring/drift_verdict.hpp"

#include <gtest/gtest.h>

#include "drivers/measurement/angles.hpp"

namespace infuse::monitoring {
namespace {

DriftVerdict verdict_along(Axis axis) {
  DriftVerdict verdict{
      .drift = Drift::kConfirmed, .axis = axis, .evidence = 20.44, .threshold = 19.06};
  verdict.offset << 0.52 * kDegree, -0.5 * kDegree, 0, 0.031, 0, -0.2;
  verdict.sigma << 0.03 * kDegree, 0.02 * kDegree, 0, 0.004, 0, 0.01;
  verdict.delay = 0.0504;
  return verdict;
}

TEST(DriftVerdict, IsDescribedWithItsSizeAndItsEvidence) {
  EXPECT_EQ(describe_drift(verdict_along(Axis::kRotationX)),
            "rotation about x by +0.52 ± 0.03° (evidence 20.4, threshold 19.1 nats)");
  EXPECT_EQ(describe_drift(verdict_along(Axis::kTranslationZ)),
            "translation along z by -20.00 ± 1.00 cm (evidence 20.4, threshold 19.1 nats)");
  EXPECT_EQ(describe_drift(verdict_along(Axis::kTime)),
            "stamps 50 ms late (evidence 20.4, threshold 19.1 nats)");
}

TEST(DriftVerdict, SaysWhatItCannotTellFromADelay) {
  DriftVerdict turned = verdict_along(Axis::kRotationY);
  turned.delay_ambiguous_axis = Axis::kRotationY;
  EXPECT_EQ(
      describe_drift(turned),
      "rotation about y by -0.50 ± 0.02° (or late stamps: this motion does not separate them) "
      "(evidence 20.4, threshold 19.1 nats)");
  DriftVerdict late = verdict_along(Axis::kTime);
  late.delay_ambiguous_axis = Axis::kRotationY;
  EXPECT_EQ(describe_drift(late),
            "stamps 50 ms late (or rotation about y: this motion does not separate them) (evidence "
            "20.4, threshold 19.1 nats)");
}

TEST(DriftVerdict, ADriftAlongTimeIsALateCamera) {
  DriftVerdict late = verdict_along(Axis::kTime);
  late.set_fault(CameraFault::kNone);
  EXPECT_EQ(late.fault, CameraFault::kLate);
  late.set_fault(CameraFault::kDirty);
  EXPECT_EQ(late.fault, CameraFault::kDirty);
  late.drift = Drift::kSuspected;
  late.set_fault(CameraFault::kNone);
  EXPECT_EQ(late.fault, CameraFault::kNone);
  late.drift = Drift::kHolds;
  late.set_fault(CameraFault::kNone);
  EXPECT_EQ(late.fault, CameraFault::kNone);
  late.set_fault(CameraFault::kNone, "left");
  EXPECT_EQ(late.fault, CameraFault::kSwapped);
  EXPECT_EQ(describe_fault(late), "swapped: its images are those of the camera left");
  late.set_fault(CameraFault::kFrozen, "left");
  EXPECT_EQ(describe_fault(late), "frozen");
  EXPECT_EQ(late.images_of, "");
  DriftVerdict moved = verdict_along(Axis::kRotationX);
  moved.set_fault(CameraFault::kNone);
  EXPECT_EQ(moved.fault, CameraFault::kNone);
}

}  // namespace
}  // namespace infuse::monitoring
