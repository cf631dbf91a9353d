#include "daemon/mapping/map_settings.hpp"

namespace infuse::daemon {

std::optional<std::string> MapSettings::invalid() const {
  for (const double share : {max_unmeasured, max_unregistered}) {
    if (!(share >= 0 && share <= 1)) return "shares of sweeps must be between 0 and 1";
  }
  if (auto wrong = keyframes.invalid()) return wrong;
  if (auto wrong = submaps.invalid()) return wrong;
  if (auto wrong = search.invalid()) return wrong;
  if (auto wrong = check.invalid()) return wrong;
  if (auto wrong = join.invalid()) return wrong;
  if (auto wrong = kept_clouds.invalid()) return wrong;
  return earth.invalid();
}

nlohmann::ordered_json to_json(const MapSettings& settings) {
  const mapping::KeyframeOptions& k = settings.keyframes;
  const mapping::SubmapOptions& m = settings.submaps;
  const mapping::ClosureSearchOptions& s = settings.search;
  const mapping::ClosureCheckOptions& c = settings.check;
  const places::JoinOptions& j = settings.join;
  const places::PlaceSelectionOptions& p = settings.kept_clouds;
  const mapping::EarthFitOptions& e = settings.earth;
  return {{"close_loops", settings.close_loops},
          {"use_gnss", settings.use_gnss},
          {"max_unmeasured", settings.max_unmeasured},
          {"max_unregistered", settings.max_unregistered},
          {"keyframes",
           {{"distance", k.distance},
            {"rotation", k.rotation},
            {"rotation_drift", k.rotation_drift},
            {"translation_drift", k.translation_drift},
            {"unmeasured_rotation", k.unmeasured_rotation},
            {"unmeasured_translation", k.unmeasured_translation}}},
          {"submaps",
           {{"voxel_size", m.voxel_size}, {"min_range", m.min_range}, {"max_range", m.max_range}}},
          {"search",
           {{"min_way", s.min_distance_driven},
            {"max_distance", s.max_distance},
            {"spacing", s.spacing},
            {"sigmas", s.sigmas},
            {"max_search", s.max_search},
            {"max_guess_error", s.max_guess_error},
            {"search_spacing", s.search_spacing}}},
          {"check",
           {{"voxel_size", c.voxel_size},
            {"min_inliers", c.min_inliers},
            {"min_agreement", c.min_agreement},
            {"min_overlap", c.min_overlap},
            {"max_difference", c.max_difference},
            {"max_difference_rotation", c.max_difference_rotation},
            {"rotation_noise", c.rotation_noise},
            {"translation_noise", c.translation_noise}}},
          {"join",
           {{"spacing", j.spacing},
            {"candidates", j.candidates},
            {"distinct", j.distinct},
            {"min_agreement", j.min_agreement},
            {"min_overlap", j.min_overlap},
            {"enough", j.enough},
            {"min_closures", j.agreement.min_closures},
            {"widening", j.agreement.widening},
            {"max_rival", j.agreement.max_rival}}},
          {"kept_clouds", {{"distance", p.distance}, {"min_seen", p.min_seen}}},
          {"earth",
           {{"sigma", e.sigma},
            {"vertical_factor", e.vertical_factor},
            {"spacing", e.spacing},
            {"correlation", e.correlation},
            {"max_outlier_sigmas", e.max_outlier_sigmas},
            {"min_fixes", e.min_fixes},
            {"min_extent", e.min_extent},
            {"min_inliers", e.min_inliers},
            {"roll_sigma", e.roll_sigma},
            {"pitch_sigma", e.pitch_sigma},
            {"slope_correlation", e.slope_correlation}}}};
}

}  // namespace infuse::daemon
