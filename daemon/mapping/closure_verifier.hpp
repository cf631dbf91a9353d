#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "daemon/mapping/map_folder.hpp"
#include "fusion/mapping/closure_check.hpp"
#include "fusion/mapping/closure_search.hpp"

namespace infuse::daemon {

/// Verifies the closures of a map by its clouds, and keeps what it found in closures.csv, so that a
/// run that was interrupted goes on with the same numbers.
class ClosureVerifier {
 public:
  /// The folder and the drive outlive this.
  ClosureVerifier(const MapFolder& folder, const MapDrive& drive,
                  const mapping::ClosureCheckOptions& options)
      : folder_(folder), drive_(drive), options_(options) {}

  /// Reads what an interrupted run left, if there is any.
  Result<void> resume();

  /// As `mapping::VerifyClosure`; with a heading `yaw` (rad) as `places::VerifyPlaces`.
  Result<void> verify(mapping::Closure& closure, std::optional<double> yaw = std::nullopt);

  /// Writes all closures with the reasons that the search has added.
  Result<void> finish(const std::vector<mapping::Closure>& closures);

 private:
  Result<std::shared_ptr<const mapping::PreparedSubmap>> prepare(size_t keyframe);
  Result<void> check(mapping::Closure& closure, std::optional<double> yaw);
  Result<void> write() const;

  struct Prepared {
    size_t keyframe;
    std::shared_ptr<const mapping::PreparedSubmap> submap;
  };

  const MapFolder& folder_;
  const MapDrive& drive_;
  mapping::ClosureCheckOptions options_;
  std::deque<Prepared> prepared_;  // the latest
  std::string header_;
  std::vector<std::string> rows_;  // of closures.csv: the text, which restores the numbers exactly
  size_t next_ = 0;                // row of the next closure
};

}  // namespace infuse::daemon
