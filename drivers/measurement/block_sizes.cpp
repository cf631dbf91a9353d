#include "drivers/measurement/block_sizes.hpp"

#include <Eigen/Core>

namespace infuse {

void fix_block_sizes() { Eigen::setCpuCacheSizes(32 << 10, 256 << 10, 2 << 20); }

}  // namespace infuse
