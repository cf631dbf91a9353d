#include "daemon/pages/offset_chart.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

namespace infuse::daemon {
namespace {

constexpr double kChartWidth = 340, kChartHeight = 190;            // px
constexpr double kPlotLeft = 48, kPlotTop = 26, kPlotMargin = 12;  // px
constexpr double kPlotInset = 6;                                   // px, to the first point
constexpr double kPlotRight = kChartWidth - kPlotMargin, kPlotBottom = kChartHeight - 24;
constexpr double kSigmas95 = 1.959964;  // 95 % of a normal distribution

/// Where values and times are in the drawing.
struct ChartScale {
  double low = 0, high = 0, days = 1;

  double x(double at) const {
    return kPlotLeft + kPlotInset + (kPlotRight - kPlotLeft - 2 * kPlotInset) * at / days;
  }
  double y(double value) const {
    return kPlotBottom - (kPlotBottom - kPlotTop) * (value - low) / (high - low);
  }
};

/// The range of what is drawn, zero included.
ChartScale scale_of(const OffsetChart& chart) {
  ChartScale scale{.days = std::max(chart.days, 1e-9)};
  const auto include = [&](double value, double sigma) {
    scale.low = std::min(scale.low, value - kSigmas95 * sigma);
    scale.high = std::max(scale.high, value + kSigmas95 * sigma);
  };
  for (const ChartPoint& point : chart.points) include(point.value, point.sigma);
  for (const ChartBand& band : chart.bands) include(band.value, band.sigma);
  const double margin = std::max(0.06 * (scale.high - scale.low), 0.005);
  scale.low -= margin;
  scale.high += margin;
  return scale;
}

/// Step between the labels of an axis: 1, 2 or 5 times a power of ten, three to seven of them.
double label_step(double span) {
  const double power = std::pow(10.0, std::floor(std::log10(span / 3)));
  for (const double factor : {5.0, 2.0}) {
    if (span / (factor * power) >= 3) return factor * power;
  }
  return power;
}

std::string grid_svg(const OffsetChart& chart, const ChartScale& scale) {
  std::string svg = fmt::format("<text class=strong x=4 y=15>{}, {}</text>", html_text(chart.title),
                                html_text(chart.unit));
  const double step = label_step(scale.high - scale.low);
  const int digits = std::clamp(static_cast<int>(-std::floor(std::log10(step) + 1e-9)), 0, 6);
  for (double k = std::ceil(scale.low / step); k * step <= scale.high; ++k) {
    const double y = scale.y(k * step);
    svg += fmt::format(
        "<line x1={} x2={} y1={:.1f} y2={:.1f} stroke=\"var(--line)\"{}/>"
        "<text x={} y={:.1f} text-anchor=end>{:.{}f}</text>",
        kPlotLeft, kPlotRight, y, y, k == 0 ? " stroke-width=2 stroke-dasharray=\"5 4\"" : "",
        kPlotLeft - 5, y + 4, k * step + 0.0, digits);
  }
  svg += fmt::format("<text x={} y={}>{}</text>", kPlotLeft, kChartHeight - 7,
                     html_text(chart.first_date));
  if (chart.last_date == chart.first_date) return svg;
  return svg + fmt::format("<text x={} y={} text-anchor=end>{}</text>", kPlotRight,
                           kChartHeight - 7, html_text(chart.last_date));
}

}  // namespace

std::string html_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string draw(const OffsetChart& chart) {
  const ChartScale scale = scale_of(chart);
  std::string svg = fmt::format("<svg viewBox=\"0 0 {} {}\" role=img aria-label=\"{}\">",
                                kChartWidth, kChartHeight, html_text(chart.title));
  svg += grid_svg(chart, scale);
  for (const ChartBand& band : chart.bands) {
    const double half = kSigmas95 * band.sigma;
    const double left = scale.x(band.from), right = std::max(scale.x(band.to), left + 2);
    svg += fmt::format(
        "<rect class=band x={:.1f} y={:.1f} width={:.1f} height={:.1f} />"
        "<line class=pooled x1={:.1f} x2={:.1f} y1={:.1f} y2={:.1f} />",
        left, scale.y(band.value + half), right - left,
        std::max(scale.y(band.value - half) - scale.y(band.value + half), 1.0), left, right,
        scale.y(band.value), scale.y(band.value));
  }
  for (const double mark : chart.marks) {
    svg += fmt::format("<line class=change x1={:.1f} x2={:.1f} y1={} y2={} />", scale.x(mark),
                       scale.x(mark), kPlotTop, kPlotBottom);
  }
  for (const ChartPoint& point : chart.points) {
    const double half = kSigmas95 * point.sigma, x = scale.x(point.days);
    svg += fmt::format(
        "<line class=bar x1={:.1f} x2={:.1f} y1={:.1f} y2={:.1f} />"
        "<circle cx={:.1f} cy={:.1f} r=3><title>{}</title></circle>",
        x, x, scale.y(point.value - half), scale.y(point.value + half), x, scale.y(point.value),
        html_text(point.name));
  }
  return svg + "</svg>";
}

}  // namespace infuse::daemon
