#pragma once

#include <cstdint>

namespace infuse {

/// Instruction sets for which kernels are compiled. All variants of a kernel do the same arithmetic
/// on every number in the same order, so all give the same bytes; only the time differs.
enum class InstructionSet : uint8_t {
  kBaseline,  ///< x86-64: SSE2, arm64: NEON; the only one on other processors
  kAvx2,      ///< AVX2
  kAvx512,    ///< x86-64-v4: AVX-512 F, BW, CD, DQ, VL
};

/// True if this processor supports `set`.
bool supported(InstructionSet set);

/// The widest instruction set that this processor supports.
InstructionSet best_instruction_set();

/// Returns the variant of a kernel for `set`, which the processor must support.
template <class Kernel>
Kernel* select_variant(InstructionSet set, Kernel* baseline, Kernel* avx2, Kernel* avx512) {
  switch (set) {
    case InstructionSet::kAvx512:
      return avx512;
    case InstructionSet::kAvx2:
      return avx2;
    case InstructionSet::kBaseline:
      break;
  }
  return baseline;
}

/// The variants of a kernel of this type. `Body::run` is the kernel, and must be inlined always, so
/// that each variant compiles it with its own instructions.
template <class Body, class Kernel>
struct KernelVariants;

template <class Body, class Result, class... Arguments>
struct KernelVariants<Body, Result (*)(Arguments...)> {
  static Result baseline(Arguments... arguments) { return Body::run(arguments...); }

#ifdef __x86_64__
  [[gnu::target("avx2")]] static Result avx2(Arguments... arguments) {
    return Body::run(arguments...);
  }
#else
  static constexpr auto avx2 = baseline;
#endif

  static auto select(InstructionSet set) { return select_variant(set, baseline, avx2, avx2); }
};

}  // namespace infuse
