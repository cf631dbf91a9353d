#pragma once

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <istream>
#include <stdexcept>
#include <string>
#include <vector>

namespace infuse::study {

/// Tries the seeds from `seed` on. Rows of all trials go to `file`. Seeds that it has are not tried
/// again: a run that was stopped goes on. Returns all trials of the file. Throws std::runtime_error
/// if it cannot be written.
template <class Trial, class Attempt>
std::vector<Trial> resume(const std::string& file, uint64_t seed, int count,
                          std::vector<Trial> (*read)(std::istream&),
                          void (*write_header_of)(std::ostream&),
                          void (*write)(std::ostream&, const Trial&), const Attempt& attempt) {
  std::ifstream before(file);
  std::vector<Trial> all = read(before);
  std::ofstream rows(file, std::ios::app);
  if (!rows) throw std::runtime_error(file + ": cannot be written");
  rows << '\n';  // ends a row whose writing was interrupted
  write_header_of(rows);
  for (uint64_t next = seed; next < seed + static_cast<uint64_t>(count); ++next) {
    if (std::any_of(all.begin(), all.end(), [&](const Trial& t) { return t.seed == next; }))
      continue;
    for (const Trial& trial : attempt(next)) {
      write(rows, trial);
      all.push_back(trial);
    }
    rows << std::flush;
  }
  return all;
}

}  // namespace infuse::study
