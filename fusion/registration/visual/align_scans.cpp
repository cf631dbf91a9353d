#include "fusion/registration/visual/align_scans.hpp"

#include "fusion/registration/visual/learned_codebook.hpp"
#include "fusion/registration/visual/scan_features.hpp"

namespace infuse::registration {
namespace {

Result<CodewordCloud> find_codewords(const CameraLidarScan& scan) {
  const auto features = compute_scan_features(scan, ScanFeature::kFpfhSift);
  if (!features) return tl::unexpected(features.error());
  return CodewordCloud{features->points, quantise(learned_codebook(), features->vectors)};
}

}  // namespace

Result<RegistrationResult> align_scans_by_information(const CameraLidarScan& target,
                                                      const CameraLidarScan& source,
                                                      const InformationAlignmentOptions& options) {
  const auto target_words = find_codewords(target);
  if (!target_words) return tl::unexpected(target_words.error());
  const auto source_words = find_codewords(source);
  if (!source_words) return tl::unexpected(source_words.error());
  return align_by_information(learned_codebook(), *target_words, *source_words, options);
}

}  // namespace infuse::registration
