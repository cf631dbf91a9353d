#pragma once

#include <string>
#include <vector>

namespace infuse::daemon {

/// A value at a time, with its standard deviation.
struct ChartPoint {
  double days = 0;
  double value = 0;
  double sigma = 0;
  std::string name;  ///< shown where the pointer rests
};

/// A value that holds from one time to another.
struct ChartBand {
  double from = 0, to = 0;  ///< days
  double value = 0, sigma = 0;
};

/// A chart of one axis of a camera's pose over time.
struct OffsetChart {
  std::string title, unit;
  std::string first_date, last_date;  ///< labels of the ends
  double days = 0;                    ///< length of the time axis, which begins at 0
  std::vector<ChartPoint> points;
  std::vector<ChartBand> bands;
  std::vector<double> marks;  ///< times at which a change begins
};

/// Draws a chart as an SVG element: points with bars of 95 %, bands of 95 %, a dashed line at zero.
/// At most a few thousand points are meant. Pure text: no script, no reference.
std::string draw(const OffsetChart& chart);

/// Escapes text for HTML, attributes included.
std::string html_text(const std::string& text);

}  // namespace infuse::daemon
