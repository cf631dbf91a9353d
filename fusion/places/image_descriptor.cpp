#include "fusion/places/image_descriptor.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::places {

std::optional<std::string> ImageDescriptorOptions::invalid() const {
  if (cell < 2) return "cell must be at least 2 pixels";
  if (stride < 1 || stride > cell) return "stride must be between 1 and cell pixels";
  if (orientations < 2 || orientations > 32) return "orientations must be between 2 and 32";
  return std::nullopt;
}

ImageDescriptor describe_image(std::span<const uint8_t> pixels, int width, int height,
                               const ImageDescriptorOptions& options) {
  ImageDescriptor out;
  out.orientations = options.orientations;
  if (width < options.cell || height < options.cell) return out;
  out.rows = (height - options.cell) / options.stride + 1;
  out.columns = (width - options.cell) / options.stride + 1;
  const auto bins = static_cast<size_t>(options.orientations);
  const auto pixel = [&](int row, int column) {
    return static_cast<float>(pixels[static_cast<size_t>(std::clamp(row, 0, height - 1) * width +
                                                         std::clamp(column, 0, width - 1))]);
  };
  // Each edge counts for the two orientations beside its own.
  std::vector<float> edges(static_cast<size_t>(width * height) * bins, 0);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const float dx = pixel(row, column + 1) - pixel(row, column - 1);
      const float dy = pixel(row + 1, column) - pixel(row - 1, column);
      const float strength = std::hypot(dx, dy);
      if (strength == 0) continue;
      const double turns = std::atan2(dy, dx) / M_PI;  // -1 … 1, period 1
      const double place = (turns - std::floor(turns)) * static_cast<double>(bins);
      const auto below = static_cast<size_t>(place);
      const auto share = static_cast<float>(place - static_cast<double>(below));
      float* at = &edges[static_cast<size_t>(row * width + column) * bins];
      at[below % bins] += strength * (1 - share);
      at[(below + 1) % bins] += strength * share;
    }
  }
  out.values.assign(static_cast<size_t>(out.rows * out.columns) * bins, 0);
  float* cell = out.values.data();
  for (int i = 0; i < out.rows; ++i) {
    for (int j = 0; j < out.columns; ++j, cell += bins) {
      float sum = 1;  // a grey value: noise in a flat cell has no orientation
      for (int row = i * options.stride; row < i * options.stride + options.cell; ++row) {
        for (int column = j * options.stride; column < j * options.stride + options.cell;
             ++column) {
          const float* at = &edges[static_cast<size_t>(row * width + column) * bins];
          for (size_t bin = 0; bin < bins; ++bin) {
            cell[bin] += at[bin];
            sum += at[bin];
          }
        }
      }
      for (size_t bin = 0; bin < bins; ++bin) cell[bin] = std::sqrt(cell[bin] / sum);
    }
  }
  return out;
}

ImageDescriptor describe_contrast(std::span<const uint8_t> pixels, int width, int height,
                                  int window) {
  ImageDescriptor out{.rows = height, .columns = width, .orientations = 1, .values = {}};
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const int top = std::max(0, row - window / 2), left = std::max(0, column - window / 2);
      const int bottom = std::min(height, row + window / 2 + 1);
      const int right = std::min(width, column + window / 2 + 1);
      const auto count = static_cast<float>((bottom - top) * (right - left));
      float sum = 0, square = 0;
      for (int i = top; i < bottom; ++i) {
        for (int j = left; j < right; ++j) {
          const auto value = static_cast<float>(pixels[static_cast<size_t>(i * width + j)]);
          sum += value;
          square += value * value;
        }
      }
      const float mean = sum / count;
      const float variance = std::max(0.0F, square / count - mean * mean);
      const auto own = static_cast<float>(pixels[static_cast<size_t>(row * width + column)]);
      out.values.push_back((own - mean) / std::sqrt(variance + 1));  // a grey value of noise
    }
  }
  return out;
}

void remove_common_view(std::vector<ImageDescriptor>& drive) {
  if (drive.empty()) return;
  std::vector<float> mean(drive[0].values.size(), 0);
  for (const ImageDescriptor& image : drive) {
    for (size_t i = 0; i < mean.size(); ++i) mean[i] += image.values[i];
  }
  for (float& value : mean) value /= static_cast<float>(drive.size());
  for (ImageDescriptor& image : drive) {
    float square = 1e-12F;
    for (size_t i = 0; i < mean.size(); ++i) {
      image.values[i] -= mean[i];
      square += image.values[i] * image.values[i];
    }
    for (float& value : image.values) value /= std::sqrt(square);
  }
}

double similarity(const ImageDescriptor& a, const ImageDescriptor& b, int max_shift) {
  double best = -1;
  if (a.values.size() != b.values.size() || a.columns != b.columns || a.columns <= max_shift) {
    return best;
  }
  const int bins = a.orientations;
  for (int shift = -max_shift; shift <= max_shift; ++shift) {
    const int begin = std::max(0, shift), end = std::min(a.columns, a.columns + shift);
    double product = 0, square_a = 1e-12, square_b = 1e-12;
    for (int row = 0; row < a.rows; ++row) {
      const float* p = &a.values[static_cast<size_t>((row * a.columns + begin) * bins)];
      const float* q = &b.values[static_cast<size_t>((row * a.columns + begin - shift) * bins)];
      float dot = 0, aa = 0, bb = 0;
      for (int i = 0; i < (end - begin) * bins; ++i) {
        dot += p[i] * q[i];
        aa += p[i] * p[i];
        bb += q[i] * q[i];
      }
      product += static_cast<double>(dot);
      square_a += static_cast<double>(aa);
      square_b += static_cast<double>(bb);
    }
    best = std::max(best, product / std::sqrt(square_a * square_b));
  }
  return best;
}

}  // namespace infuse::places
