#include "drivers/measurement/instruction_set.hpp"

namespace infuse {

bool supported(InstructionSet set) {
#ifdef __x86_64__
  switch (set) {
    case InstructionSet::kAvx512:
      return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
             __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
             __builtin_cpu_supports("avx512vl");
    case InstructionSet::kAvx2:
      return __builtin_cpu_supports("avx2");
    case InstructionSet::kBaseline:
      break;
  }
#endif
  return set == InstructionSet::kBaseline;
}

InstructionSet best_instruction_set() {
  static const InstructionSet best = supported(InstructionSet::kAvx512) ? InstructionSet::kAvx512
                                     : supported(InstructionSet::kAvx2) ? InstructionSet::kAvx2
                                                                        : InstructionSet::kBaseline;
  return best;
}

}  // namespace infuse
