#pragma once

#include <array>
#include <complex>
#include <cstdint>

#include "drivers/lidar/azimuth.hpp"

namespace infuse::lidar {

/// Cosine and sine of an angle.
struct CosSin {
  float cos, sin;
};

/// Cosine and sine of all azimuths, from those of whole degrees and of hundredths.
class AzimuthTable {
 public:
  AzimuthTable() {
    for (size_t i = 0; i < degrees_.size(); ++i) {
      degrees_[i] = std::polar(1.0, static_cast<double>(i) * 100 * kCentidegree);
    }
    for (size_t i = 0; i < hundredths_.size(); ++i) {
      hundredths_[i] = std::polar(1.0, static_cast<double>(i) * kCentidegree);
    }
  }

  /// `azimuth` in 0.01°, 0 … 35999.
  CosSin at(uint16_t azimuth) const {
    const Complex& a = degrees_[azimuth / 100];
    const Complex& b = hundredths_[azimuth % 100];
    return {static_cast<float>(a.real() * b.real() - a.imag() * b.imag()),
            static_cast<float>(a.imag() * b.real() + a.real() * b.imag())};
  }

 private:
  using Complex = std::complex<double>;
  std::array<Complex, 360> degrees_;
  std::array<Complex, 100> hundredths_;
};

}  // namespace infuse::lidar
