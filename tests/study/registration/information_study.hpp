#pragma once

#include <filesystem>
#include <iosfwd>

namespace infuse::study {

/// Extent of the study of alignment by mutual information (P figs. 4.18 to 4.21).
struct InformationStudyOptions {
  uint64_t first_seed = 1001;  ///< of the drives: towns and light that no codebook was learned from
  int drives = 8;              ///< of 28 pairs each, 1 to 10 m apart
  int variant_drives = 1;   ///< number of those drives that are aligned with every vocabulary too
  int training_drives = 6;  ///< for the codebooks that are not shipped
};

/// Aligns all pairs by all methods, from no guess. Appends a row for each to `rows` (CSV), a drive
/// at a time; drives that it holds already are not rendered again. Throws std::runtime_error.
void run_information_study(const std::filesystem::path& rows,
                           const InformationStudyOptions& options);

/// Writes a table of the rows: the share that converged (0.3 m and 1°), by method and distance.
void write_information_table(std::ostream& out, const std::filesystem::path& rows);

/// Writes the mutual information of FPFH and SIFT against the displacement from the truth, for the
/// scans 4.6 m apart of one drive (P fig. 4.21).
void write_information_profile(std::ostream& out, uint64_t seed);

}  // namespace infuse::study
