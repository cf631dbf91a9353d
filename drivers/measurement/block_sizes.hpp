#pragma once

namespace infuse {

/// Eigen cuts products of large matrices into blocks by the sizes of the processor's caches, and
/// the order of the sums follows the blocks. Sets the same sizes on every processor, so that all
/// give the same bytes. Called once, before the first product.
void fix_block_sizes();

}  // namespace infuse
