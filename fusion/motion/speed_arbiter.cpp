#include "fusion/motion/speed_arbiter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace infuse::motion {
namespace {

constexpr double kMaxAcceleration = 12;  // m/s²: tyres on a dry road hold 1.2 g
// Of equal costs, the first: wheels slip more often than a registration errs.
constexpr OdometrySource kByTrust[] = {OdometrySource::kLidar, OdometrySource::kWheels,
                                       OdometrySource::kSpeed, OdometrySource::kGnssSpeed};

double square_of(double x) { return x * x; }

}  // namespace

double SpeedArbiter::impossible(double change, double seconds, double tolerance) {
  const double possible = kMaxAcceleration * seconds + tolerance;
  return change - std::clamp(change, -possible, possible);
}

void SpeedArbiter::add(OdometrySource source, const Claim& claim, Duration lasts) {
  Record& record = at(source);
  const Stamp before = record.claim.stamp;
  record.claim = claim;
  const bool jumps = std::abs(claim.jump) > 0;  // not NaN
  if (jumps) {
    record.jumped += claim.jump;
    put_out(source, claim.stamp);
  }
  record.furthest = std::max(record.furthest, std::abs(record.jumped));
  const bool is_back = record.furthest > 0 && std::abs(record.jumped) <= 0.5 * record.furthest;
  const bool is_over = record.out && !jumps && claim.stamp - record.since > lasts;
  if (is_back || is_over) record.readmit();
  if (is_over) agreement_ = {};  // what it was out for is no news
  agree(source, before);
}

// Compared with what came since the sample before: the slower of two sources compares them. A
// source that is out agrees at once with one that is not: both in error, by the same, is seldom.
void SpeedArbiter::agree(OdometrySource source, Stamp since) {
  const Stamp now = at(source).claim.stamp;
  Agreement found;
  found.speed.fill(std::numeric_limits<double>::quiet_NaN());
  for (const OdometrySource other : kByTrust) {
    Record& a = at(source);
    Record& b = at(other);
    if (other == source || (a.out && b.out)) continue;
    if (b.claim.stamp <= since || !is_recent(other, now)) continue;
    if (sigmas_apart(source, other) > 1) continue;
    a.readmit();
    b.readmit();
    found.stamp = now;
    found.speed[static_cast<size_t>(source)] = a.claim.speed;
    found.speed[static_cast<size_t>(other)] = b.claim.speed;
  }
  if (found.stamp != Stamp::earliest()) agreement_ = found;
}

void SpeedArbiter::correct(double change) {
  for (Record& record : records_) record.claim.error -= change;
}

bool SpeedArbiter::is_recent(OdometrySource source, Stamp now) const {
  const Stamp stamp = at(source).claim.stamp;
  const Duration silence =
      source == OdometrySource::kGnssSpeed ? options_.max_gnss_silence : options_.max_silence;
  return stamp != Stamp::earliest() && now - stamp <= silence;
}

bool SpeedArbiter::takes_part(OdometrySource source, Stamp now) const {
  return !is_out(source) && is_recent(source, now);
}

// What the vehicle did between the two samples is known to the state, but for its acceleration.
double SpeedArbiter::sigmas_apart(OdometrySource a, OdometrySource b) const {
  const Claim &first = at(a).claim, &second = at(b).claim;
  const double apart = std::abs(to_seconds(first.stamp - second.stamp));
  const double unseen = options_.acceleration_walk * std::pow(apart, 1.5) / std::sqrt(3);
  return std::abs(first.error - second.error) /
         std::sqrt(square_of(first.sigma) + square_of(second.sigma) + square_of(unseen));
}

double SpeedArbiter::cost(OdometrySource source, Stamp now) const {
  const Claim& claim = at(source).claim;
  double sum = 0;
  for (const OdometrySource other : kByTrust) {
    if (other == source || !takes_part(other, now)) continue;
    sum += square_of(std::min(kGateSigmas, sigmas_apart(source, other)));
  }
  const double before = agreement_.speed[static_cast<size_t>(source)];
  if (agreement_.stamp == Stamp::earliest() || !std::isfinite(before) ||
      now - agreement_.stamp > options_.max_gnss_silence) {
    return sum;
  }
  const double possible =
      kMaxAcceleration / kGateSigmas * to_seconds(claim.stamp - agreement_.stamp);
  return sum + square_of(claim.speed - before) / (square_of(possible) + square_of(claim.sigma));
}

bool SpeedArbiter::judge(OdometrySource source) {
  if (is_out(source)) return false;
  const Stamp now = at(source).claim.stamp;
  double least = std::numeric_limits<double>::infinity();
  OdometrySource right = source;
  for (const OdometrySource candidate : kByTrust) {
    if (!takes_part(candidate, now)) continue;
    const double its = cost(candidate, now);
    if (its >= least) continue;
    least = its;
    right = candidate;
  }
  for (const OdometrySource other : kByTrust) {
    if (other == right || !takes_part(other, now)) continue;
    if (sigmas_apart(other, right) > kGateSigmas) put_out(other, now);
  }
  return !is_out(source);
}

void SpeedArbiter::put_out(OdometrySource source, Stamp now) {
  at(source).out = true;
  at(source).since = now;
}

void SpeedArbiter::reset() {
  records_ = {};
  agreement_ = {};
}

}  // namespace infuse::motion
