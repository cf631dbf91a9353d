#pragma once

#include <charconv>
#include <cstdint>
#include <iomanip>
#include <sstream>
#include <string>
#include <string_view>

namespace infuse {

/// Elements of an OpenStreetMap XML text, without its header and its bounds.
inline std::string_view elements_of_osm(std::string_view xml) {
  const size_t first = std::min(xml.find("<node "), xml.find("<way "));
  return xml.substr(first, xml.rfind("</osm>") - first);
}

/// A copy of OpenStreetMap XML elements with shifted ids and coordinates (degrees).
inline std::string shift_osm(std::string_view elements, int64_t id_shift, double latitude_shift,
                             double longitude_shift) {
  std::ostringstream shifted;
  shifted << std::fixed << std::setprecision(7);
  for (size_t at = 0; at < elements.size();) {
    const size_t space = elements.find(' ', at);
    if (space == std::string_view::npos) {
      shifted << elements.substr(at);
      break;
    }
    const std::string_view rest = elements.substr(space + 1);
    const bool is_id = rest.starts_with("id=") || rest.starts_with("ref=");
    const bool is_latitude = rest.starts_with("lat="), is_longitude = rest.starts_with("lon=");
    if (!is_id && !is_latitude && !is_longitude) {
      shifted << elements.substr(at, space + 1 - at);
      at = space + 1;
      continue;
    }
    const size_t number = space + 1 + rest.find('=') + 2;
    const size_t end = elements.find_first_of("'\"", number);
    shifted << elements.substr(at, number - at);
    if (is_id) {
      int64_t id = 0;
      std::from_chars(elements.data() + number, elements.data() + end, id);
      shifted << id + id_shift;
    } else {
      double degrees = 0;
      std::from_chars(elements.data() + number, elements.data() + end, degrees);
      shifted << degrees + (is_latitude ? latitude_shift : longitude_shift);
    }
    at = end;
  }
  return shifted.str();
}

/// An extract as downloads are: copies of a small one on a grid over `bounds_edge` × `bounds_edge`
/// degrees, its bounds stated, and, if asked for, one wood as a relation of four ways over 0.6 of
/// that edge in both directions.
inline std::string large_extract(std::string_view small, int copies_along, double bounds_edge,
                                 double latitude, double longitude, bool wood) {
  std::ostringstream xml;
  xml << std::fixed << std::setprecision(7) << "<osm version='0.6'>\n<bounds minlat='" << latitude
      << "' minlon='" << longitude << "' maxlat='" << latitude + bounds_edge << "' maxlon='"
      << longitude + bounds_edge << "'/>\n";
  const std::string_view elements = elements_of_osm(small);
  constexpr int64_t kIdShift = 100'000'000'000;
  for (int i = 0; i < copies_along * copies_along; ++i) {
    const double step = bounds_edge / copies_along;
    xml << shift_osm(elements, (i + 1) * kIdShift, i / copies_along * step,
                     i % copies_along * step);
  }
  if (wood) {
    for (int corner = 0; corner < 4; ++corner) {
      const bool north = corner / 2 == 1, east = corner == 1 || corner == 2;
      xml << "<node id='" << corner + 1 << "' lat='" << latitude + bounds_edge * (north ? 0.8 : 0.2)
          << "' lon='" << longitude + bounds_edge * (east ? 0.8 : 0.2) << "'/>\n";
    }
    for (int way = 0; way < 4; ++way) {
      xml << "<way id='" << way + 1 << "'><nd ref='" << way + 1 << "'/><nd ref='"
          << (way + 1) % 4 + 1 << "'/></way>\n";
    }
    xml << "<relation id='1'>";
    for (int way = 0; way < 4; ++way) {
      xml << "<member type='way' ref='" << way + 1 << "' role='outer'/>";
    }
    xml << "<tag k='type' v='multipolygon'/><tag k='landuse' v='forest'/></relation>\n";
  }
  xml << "</osm>\n";
  return xml.str();
}

}  // namespace infuse
