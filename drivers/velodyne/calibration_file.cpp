#include "drivers/velodyne/calibration_file.hpp"

#include <bitset>
#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <sstream>
#include <string>

#include "drivers/measurement/angles.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::velodyne {
namespace {

using Tree = boost::property_tree::ptree;

constexpr size_t kMaxFileBytes = 4 << 20;
constexpr size_t kMaxLasers = 64;
constexpr const char* kHint = "expected the vendor's db.xml with <points_> of 64 lasers";

/// Returns the end of the tag that begins at `at`: the position behind its ">", quotes respected.
/// npos if it does not end, or contains another "<", which XML forbids even in quotes.
size_t end_of_tag(std::string_view text, size_t at) {
  char quote = 0;
  for (size_t i = at + 1; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '<') return std::string_view::npos;
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      return i + 1;
    }
  }
  return std::string_view::npos;
}

/// The XML parser recurses for every level, so the depth is checked before parsing.
bool is_shallow(std::string_view text) {
  constexpr int kMaxDepth = 40;
  int depth = 0;
  for (size_t at = text.find('<'); at != std::string_view::npos; at = text.find('<', at)) {
    const std::string_view rest = text.substr(at);
    if (rest.starts_with("<!--")) {
      at = text.find("-->", at + 4);
      continue;
    }
    if (rest.starts_with("<![CDATA[")) return false;  // never used in a db.xml
    const size_t end = end_of_tag(text, at);
    if (end == std::string_view::npos) return false;
    const char kind = text[at + 1];
    if (kind == '/') {
      --depth;
    } else if (kind != '?' && kind != '!' && text[end - 2] != '/') {
      ++depth;
    }
    if (depth < 0 || depth > kMaxDepth) return false;
    at = end;
  }
  return true;
}

/// Reads the numbers of one `<px>`; false if one is missing.
bool read_beam(const Tree& px, BeamCorrection& beam) {
  constexpr double kCentimetre = 0.01;
  const auto read = [&](const char* key, double unit, double& value) {
    const auto number = px.get_optional<double>(key);
    if (number) value = *number * unit;
    return number.has_value();
  };
  return read("rotCorrection_", kDegree, beam.rotation) &&
         read("vertCorrection_", kDegree, beam.elevation) &&
         read("distCorrection_", kCentimetre, beam.distance) &&
         read("distCorrectionX_", kCentimetre, beam.distance_x) &&
         read("distCorrectionY_", kCentimetre, beam.distance_y) &&
         read("vertOffsetCorrection_", kCentimetre, beam.vertical_offset) &&
         read("horizOffsetCorrection_", kCentimetre, beam.horizontal_offset) &&
         read("focalDistance_", kCentimetre, beam.focal_distance) &&
         read("focalSlope_", 1, beam.focal_slope);
}

/// Reads one limit of reflectivity per laser from a list of `<item>`; files of early units have
/// none.
void read_limits(const Tree& db, const char* key, Calibration& calibration,
                 double BeamCorrection::*limit) {
  const auto list = db.get_child_optional(key);
  if (!list) return;
  size_t laser = 0;
  for (const auto& [name, item] : *list) {
    if (name != "item" || laser >= kMaxLasers) continue;
    auto& beam = calibration.beams[laser++];
    beam.*limit = item.get_value<double>(beam.*limit);
  }
}

Result<Calibration> read_db(const Tree& db) {
  const auto points = db.get_child_optional("points_");
  if (!points) return fail("no <points_>", {}, kHint);
  Calibration calibration;
  std::bitset<kMaxLasers> known;
  for (const auto& [name, item] : *points) {
    const auto px = item.get_child_optional("px");
    if (name != "item" || !px) continue;
    const auto laser = px->get_optional<size_t>("id_");
    if (!laser || *laser >= kMaxLasers) continue;
    if (!read_beam(*px, calibration.beams[*laser])) {
      return fail("laser " + std::to_string(*laser) + " lacks a number", {}, kHint);
    }
    known.set(*laser);
  }
  if (!known.all()) {
    return fail(std::to_string(known.count()) + " of 64 lasers present", {}, kHint);
  }
  read_limits(db, "minIntensity_", calibration, &BeamCorrection::min_intensity);
  read_limits(db, "maxIntensity_", calibration, &BeamCorrection::max_intensity);
  if (auto wrong = calibration.invalid(model_info(Model::kHdl64eS3))) return fail(*wrong);
  return calibration;
}

}  // namespace

Result<Calibration> parse_db_xml(std::string_view text) {
  if (text.size() > kMaxFileBytes) return fail("larger than 4 MiB", {}, kHint);
  if (!is_shallow(text)) return fail("not a db.xml: tags too deep or broken", {}, kHint);
  try {
    std::istringstream in{std::string(text)};
    Tree tree;
    boost::property_tree::read_xml(in, tree);
    const auto db = tree.get_child_optional("boost_serialization.DB");
    if (!db) return fail("no <boost_serialization><DB>", {}, kHint);
    return read_db(*db);
  } catch (const boost::property_tree::xml_parser_error& error) {
    return fail(error.message(), "line " + std::to_string(error.line()), kHint);
  } catch (const std::exception& error) {
    return fail(error.what(), {}, kHint);
  }
}

Result<Calibration> load_db_xml(const std::filesystem::path& path) {
  const auto text = text::read_text(path, kMaxFileBytes);
  if (!text) return tl::unexpected(text.error());
  auto calibration = parse_db_xml(*text);
  if (calibration) return calibration;
  const Error& error = calibration.error();
  return fail(error.what, path.string() + (error.where.empty() ? "" : ", " + error.where),
              error.hint);
}

}  // namespace infuse::velodyne
