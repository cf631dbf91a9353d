#include "tests/study/registration/learn_codebook.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace infuse::study {

registration::ScanFeatures features_of(const PosedScan& scan, const Rig& rig,
                                       registration::ScanFeature feature) {
  const auto images = images_of(scan, rig.cameras);
  auto features = compute_scan_features({features::make_sweep_view(scan.sweep), images}, feature);
  if (!features) throw std::runtime_error(features.error().message());
  return std::move(*features);
}

std::vector<Eigen::MatrixXf> training_features(
    const CodebookRecipe& recipe, const std::vector<registration::ScanFeature>& kinds) {
  std::vector<Eigen::MatrixXf> all(kinds.size());
  for (int d = 0; d < recipe.drives; ++d) {
    const auto drive = render_drive(recipe.first_seed + static_cast<uint64_t>(d), {0, 10});
    if (!drive) throw std::runtime_error(drive.error().message());
    for (const PosedScan& scan : drive->scans) {
      for (size_t k = 0; k < kinds.size(); ++k) {
        const Eigen::MatrixXf found = features_of(scan, drive->rig, kinds[k]).vectors;
        const Eigen::Index before = all[k].cols();
        all[k].conservativeResize(found.rows(), before + found.cols());
        all[k].rightCols(found.cols()) = found;
      }
    }
  }
  return all;
}

void write_codebook(std::ostream& out, const registration::Codebook& codebook,
                    const CodebookRecipe& recipe) {
  out << "// Made by: infuse-study codebook --drives " << recipe.drives << " --words "
      << recipe.words << " (seed " << recipe.first_seed << ")\n";
  for (size_t w = 0; w < codebook.size(); ++w) {
    out << std::clamp(std::lround(codebook.frequencies[w] * 50000), 1L, 65535L);
    for (Eigen::Index r = 0; r < codebook.words.rows(); ++r) {
      out << ','
          << std::clamp(std::lround(codebook.words(r, static_cast<Eigen::Index>(w)) * 255), 0L,
                        255L);
    }
    out << ",\n";
  }
}

}  // namespace infuse::study
