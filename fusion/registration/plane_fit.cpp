#include "fusion/registration/plane_fit.hpp"

#include "drivers/measurement/simd.hpp"

namespace infuse::registration {
namespace {

/// Smallest eigenvalue of a positive semidefinite matrix: Newton's method on the characteristic
/// polynomial from 0, from where it rises to the smallest root without passing it.
[[gnu::always_inline]] inline Doubles smallest_eigenvalue(const Doubles& trace,
                                                          const Doubles& minors,
                                                          const Doubles& determinant) {
  Doubles value = {};
  for (int i = 0; i < 8; ++i) {
    const Doubles polynomial = ((trace - value) * value - minors) * value + determinant;
    const Doubles slope = (2 * trace - 3 * value) * value - minors;
    const Doubles step = slope < 0 ? polynomial / slope : Doubles{};
    value -= step;
  }
  return value;
}

/// Eigenvectors of the smallest eigenvalue: the longest cross product of two rows of A − λ.
/// `min_product` bounds the product of the other two eigenvalues, in units of their sum squared.
INFUSE_SIMD_CLONES void fit(const Covariances& covariances, double min_product, PlaneFits& out) {
  const auto& [axx, axy, axz, ayy, ayz, azz] = covariances;
  const Doubles trace = axx + ayy + azz;
  const Doubles minors = axx * ayy - axy * axy + axx * azz - axz * axz + ayy * azz - ayz * ayz;
  const Doubles determinant =
      axx * (ayy * azz - ayz * ayz) - axy * (axy * azz - ayz * axz) + axz * (axy * ayz - ayy * axz);
  const Doubles value = smallest_eigenvalue(trace, minors, determinant);
  const Doubles bxx = axx - value, byy = ayy - value, bzz = azz - value;
  const Doubles cross[3][3] = {
      {axy * ayz - axz * byy, axz * axy - bxx * ayz, bxx * byy - axy * axy},  // rows 0 and 1
      {axy * bzz - axz * ayz, axz * axz - bxx * bzz, bxx * ayz - axy * axz},  // rows 0 and 2
      {byy * bzz - ayz * ayz, ayz * axz - axy * bzz, axy * ayz - byy * axz},  // rows 1 and 2
  };
  Doubles longest = {}, nx = {}, ny = {}, nz = {};
  for (const auto& c : cross) {
    const Doubles square = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
    const auto longer = square > longest;
    longest = longer ? square : longest;
    nx = longer ? c[0] : nx;
    ny = longer ? c[1] : ny;
    nz = longer ? c[2] : nz;
  }
  // The other two eigenvalues: their sum is trace − λ, their product minors − λ (trace − λ).
  const Doubles sum = trace - value;
  const Doubles product = minors - value * sum;
  const auto flat = (product > min_product * sum * sum) & (longest > 0);
  Doubles root;
  for (int i = 0; i < kPlanes; ++i) root[i] = __builtin_sqrt(longest[i]);
  const Doubles scale = flat ? 1 / root : Doubles{};
  out = {{nx * scale, ny * scale, nz * scale}, value, sum, product};
}

}  // namespace

PlaneFits fit_planes(const Covariances& covariances, double min_spread) {
  PlaneFits out;
  // Two variances of ratio r have the product r / (1 + r)² in units of their sum squared.
  fit(covariances, min_spread / ((1 + min_spread) * (1 + min_spread)), out);
  return out;
}

}  // namespace infuse::registration
