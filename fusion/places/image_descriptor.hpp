#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace infuse::places {

/// Settings of the description of small images.
struct ImageDescriptorOptions {
  int cell = 8;           ///< pixels, side of a cell
  int stride = cell / 2;  ///< pixels between cells, derived from `cell`
  int orientations = 8;   ///< of edges, over 180°

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Edge orientations of an image by cell: what stays when light and season change. The cells of a
/// grid, row by row, with `orientations` numbers each.
struct ImageDescriptor {
  int rows = 0, columns = 0, orientations = 0;
  std::vector<float> values;
};

/// Describes a grey image (rows from the top, without padding), which should be small: 64 by 32
/// pixels will do. Square roots of the share of each orientation in the cell's edges. An image
/// smaller than a cell has no cells. `options.invalid()` must be empty.
ImageDescriptor describe_image(std::span<const uint8_t> pixels, int width, int height,
                               const ImageDescriptorOptions& options = {});

/// Describes a grey image by its local contrast instead: grey values minus the mean of the
/// `window` × `window` pixels about each, in standard deviations of these; one number a pixel. The
/// plain baseline (SeqSLAM, Milford and Wyeth 2012).
ImageDescriptor describe_contrast(std::span<const uint8_t> pixels, int width, int height,
                                  int window = 17);

/// Subtracts the mean of the images of a drive from each of them, so that what is always in view
/// (rails, bonnet, sky) does not count, and scales them to unit length. All are of one size.
void remove_common_view(std::vector<ImageDescriptor>& drive);

/// Cosine between two descriptors (-1 … 1), the greatest over sideways shifts of up to `max_shift`
/// cells; -1 if they are of different sizes or have fewer columns.
double similarity(const ImageDescriptor& a, const ImageDescriptor& b, int max_shift = 1);

}  // namespace infuse::places
