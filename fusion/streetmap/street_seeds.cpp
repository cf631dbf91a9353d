#include "fusion/streetmap/street_seeds.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "fusion/streetmap/street_directions.hpp"

namespace infuse::streetmap {
namespace {

constexpr int kBlock = 64;  // cells along the edge of a block, which bounds the time between checks
constexpr double kSeedTurn = std::numbers::pi / 4;             // rad: no bend of a street
constexpr double kTurnLength = 2 * StreetGrid::kProfileReach;  // m, within which it is
constexpr int kBins = kBlock / static_cast<int>(StreetSeeds::kSpacing);

/// m beside all streets after which a hypothesis is dropped.
double refuting_length(const GlobalStartOptions& options) {
  return options.max_log_odds / options.max_misfit * options.independent_length;
}

/// Index of the stretch from which the track has so many turns, with a straight piece before and
/// after; nothing if there are fewer.
std::optional<size_t> before_turns(std::span<const DriveStretch> track, int turns, double margin) {
  double after = 0;
  size_t i = track.size();
  while (i > 0 && after < margin) after += track[--i].length;
  while (i > 0 && turns > 0) {
    double yaw = 0, length = 0;
    for (size_t k = i; k > 0 && length < kTurnLength && std::abs(yaw) < kSeedTurn;) {
      yaw += track[--k].motion.yaw;
      length += track[k].length;
    }
    if (std::abs(yaw) < kSeedTurn) {
      --i;
      continue;
    }
    --turns;
    const double back = turns == 0 ? kTurnLength + margin : kTurnLength;
    for (length = 0; i > 0 && length < back;) length += track[--i].length;
  }
  if (turns > 0) return std::nullopt;
  return i;
}

}  // namespace

StreetSeeds::StreetSeeds(const GlobalStartOptions& options) : options_(options) {
  track_.reserve(kMaxTrack);
  found_.reserve(static_cast<size_t>(options.max_hypotheses));
}

void StreetSeeds::restart() {
  track_.clear();
  found_.clear();
  turns_ = 1;
  running_ = false;
  begin_ = end_ = 0;
}

void StreetSeeds::add(const DriveStretch& stretch) {
  if (track_.size() == kMaxTrack) {
    if (running_ && begin_ < kMaxTrack / 2) return restart();
    track_.erase(track_.begin(), track_.begin() + kMaxTrack / 2);
    if (running_) {
      begin_ -= kMaxTrack / 2;
      end_ -= kMaxTrack / 2;
    }
  }
  track_.push_back(stretch);
}

bool StreetSeeds::begin() {
  const auto from = before_turns(track_, turns_, refuting_length(options_));
  if (!from) return false;
  begin_ = *from;
  end_ = track_.size();
  block_ = 0;
  found_.clear();
  running_ = true;
  return true;
}

bool StreetSeeds::search(const StreetGrid& grid, int comparisons) {
  if (!running_ && !begin()) return false;
  const int columns = (grid.columns() + kBlock - 1) / kBlock;
  const int rows = (grid.rows() + kBlock - 1) / kBlock;
  for (; block_ < columns * rows && comparisons > 0; ++block_) {
    comparisons -= compare_block(grid, block_ % columns, block_ / columns);
    if (found_.size() < found_.capacity()) continue;
    ++turns_;
    running_ = false;
    return false;
  }
  if (block_ < columns * rows) return false;
  running_ = false;
  return true;
}

// One seed in the middle of each street that passes a bin, in both directions.
int StreetSeeds::compare_block(const StreetGrid& grid, int block_column, int block_row) {
  const int left = block_column * kBlock, low = block_row * kBlock;
  const Eigen::Vector2d corner = grid.middle(left, low);
  std::array<bool, static_cast<size_t>(kBins) * kBins * kStreetDirections> seeded{};
  const int every = static_cast<int>(options_.spacing / StreetGrid::kCell);
  int compared = 1;
  for (int row = low + every / 2; row < std::min(low + kBlock, grid.rows()); row += every) {
    for (int column = left + every / 2; column < std::min(left + kBlock, grid.columns());
         column += every) {
      const Eigen::Vector2d p = grid.middle(column, row);
      if (!grid.street(p.x(), p.y())) continue;
      ++compared;
      for_street_directions(grid, p, [&](size_t direction, double yaw) {
        const auto street = grid.across({p.x(), p.y(), yaw});
        if (!street) return;
        const Eigen::Vector2d q =
            p + street->centre() * Eigen::Vector2d(-std::sin(yaw), std::cos(yaw));
        const Eigen::Vector2d bin = (q - corner) / kSpacing;
        if (!(bin.minCoeff() >= 0 && bin.maxCoeff() < kBins)) return;
        const size_t at = (static_cast<size_t>(bin.y()) * kBins + static_cast<size_t>(bin.x())) *
                              kStreetDirections +
                          direction;
        if (seeded[at]) return;
        seeded[at] = true;
        for (const double reversed : {0.0, std::numbers::pi}) {
          compared += drive(grid, begin_hypothesis({q.x(), q.y(), wrap_angle(yaw + reversed)},
                                                   kSpacing, options_));
        }
      });
    }
  }
  return compared;
}

int StreetSeeds::drive(const StreetGrid& grid, StreetHypothesis hypothesis) {
  int compared = 0;
  for (size_t i = begin_; i < end_; ++i, ++compared) {
    advance(hypothesis, grid, track_[i], options_);
    if (hypothesis.log_weight < -options_.max_log_odds) return compared + 1;
  }
  if (found_.size() < found_.capacity()) found_.push_back(hypothesis);
  return compared;
}

}  // namespace infuse::streetmap
