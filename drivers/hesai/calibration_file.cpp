#include "drivers/hesai/calibration_file.hpp"

#include <bitset>
#include <string>
#include <vector>

#include "drivers/measurement/angles.hpp"
#include "drivers/text/numbers.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::hesai {
namespace {

constexpr size_t kMaxAngleFileBytes = 1 << 20;
constexpr const char* kAngleFileHint =
    "Hesai's angle correction file has a line \"channel,elevation,azimuth\" in degrees for each "
    "channel";

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  const size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// Removes the text before the next separator from `rest` and returns it without blanks.
std::string_view take(std::string_view& rest, char separator) {
  const size_t end = rest.find(separator);
  const std::string_view part = rest.substr(0, end);
  rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  return trimmed(part);
}

/// The angles of one channel.
struct AngleRow {
  size_t channel = 0;  // from 0
  BeamAngles angles;
};

std::optional<AngleRow> parse_row(std::string_view line, const ModelInfo& info) {
  const auto channel = text::parse_as<uint32_t>(take(line, ','));
  const auto elevation = text::parse_number(take(line, ','));
  const auto azimuth = text::parse_number(take(line, ','));
  if (!channel || !elevation || !azimuth || *channel < 1 || *channel > info.lasers) {
    return std::nullopt;
  }
  return AngleRow{*channel - 1, {*elevation * kDegree, *azimuth * kDegree}};
}

/// True for a line before the first channel: a title, column names, an empty line.
bool is_heading(std::string_view line) {
  return line.empty() || !text::parse_number(take(line, ','));
}

}  // namespace

Result<Calibration> parse_angle_csv(std::string_view text, const ModelInfo& info) {
  if (text.size() > kMaxAngleFileBytes) return fail("larger than 1 MiB", {}, kAngleFileHint);
  Calibration calibration;
  std::bitset<kMaxLasers> known;
  for (size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = take(text, '\n');
    if (line.empty() || (known.none() && is_heading(line))) continue;
    const std::string where = "line " + std::to_string(number);
    const auto row = parse_row(line, info);
    if (!row) {
      return fail("not the angles of a channel of " + std::string(info.name), where,
                  kAngleFileHint);
    }
    if (known.test(row->channel)) {
      return fail("channel " + std::to_string(row->channel + 1) + " twice", where, kAngleFileHint);
    }
    known.set(row->channel);
    calibration.beams[row->channel] = row->angles;
  }
  if (known.count() != info.lasers) {
    return fail(
        std::to_string(known.count()) + " of " + std::to_string(info.lasers) + " channels present",
        {}, kAngleFileHint);
  }
  if (auto wrong = calibration.invalid(info)) return fail(*wrong, {}, kAngleFileHint);
  return calibration;
}

Result<Calibration> load_angle_csv(const std::filesystem::path& path, const ModelInfo& info) {
  const auto text = text::read_text(path, kMaxAngleFileBytes);
  if (!text) return tl::unexpected(text.error());
  auto calibration = parse_angle_csv(*text, info);
  if (calibration) return calibration;
  const Error& error = calibration.error();
  return fail(error.what, path.string() + (error.where.empty() ? "" : ", " + error.where),
              error.hint);
}

}  // namespace infuse::hesai
