#pragma once

namespace infuse::dependence {

/// Which vector instructions a kernel of this folder is compiled for. Every variant does the same
/// arithmetic on every number in the same order, so all give the same bytes; only the time differs.
enum class InstructionSet {
  kBaseline,  ///< x86-64: SSE2
  kAvx2,      ///< AVX2
  kAvx512,    ///< x86-64-v4: AVX-512 F, BW, CD, DQ, VL
};

/// Whether this processor runs `set`.
bool supported(InstructionSet set);

/// The widest set that this processor runs.
InstructionSet best_instruction_set();

}  // namespace infuse::dependence
