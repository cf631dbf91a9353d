#include "drivers/import/calibration_text.hpp"

#include "drivers/recording/rigid_matrix.hpp"
#include "drivers/text/line_reader.hpp"
#include "drivers/text/numbers.hpp"

namespace infuse::importers {

Result<CalibrationText> CalibrationText::read(const std::filesystem::path& path) {
  auto lines = text::LineReader::open(path);
  if (!lines) return tl::unexpected(lines.error());
  CalibrationText file;
  file.name_ = path.string();
  std::string_view line;
  while (lines->next(line) && file.values_.size() < 1000) {
    const size_t colon = line.find(':');
    if (colon == std::string_view::npos) continue;
    auto numbers = text::parse_numbers(line.substr(colon + 1));
    if (numbers) file.values_[std::string(line.substr(0, colon))] = std::move(*numbers);
  }
  return file;
}

const std::vector<double>* CalibrationText::find(std::initializer_list<const char*> keys) const {
  for (const char* key : keys) {
    const auto at = values_.find(key);
    if (at != values_.end()) return &at->second;
  }
  return nullptr;
}

Result<Eigen::Matrix4d> CalibrationText::matrix(std::initializer_list<const char*> keys, int rows,
                                                int columns) const {
  const std::vector<double>* numbers = find(keys);
  if (numbers == nullptr) {
    return fail(std::string("has no ") + *keys.begin(), name_,
                "expected lines such as 'P2: 7.2e+02 …'");
  }
  if (numbers->size() != static_cast<size_t>(rows * columns)) {
    return fail(std::string(*keys.begin()) + " must be " + std::to_string(rows * columns) +
                    " numbers, " + std::to_string(numbers->size()) + " are given",
                name_);
  }
  Eigen::Matrix4d result = Eigen::Matrix4d::Identity();
  for (int i = 0; i < rows * columns; ++i) {
    result(i / columns, i % columns) = (*numbers)[static_cast<size_t>(i)];
  }
  return result;
}

Result<Eigen::Isometry3d> CalibrationText::rigid(std::initializer_list<const char*> keys,
                                                 int columns) const {
  const auto given = matrix(keys, 3, columns);
  if (!given) return tl::unexpected(given.error());
  const auto T = recording::to_rigid(*given);
  if (!T) return fail(std::string(*keys.begin()) + " is not a rigid motion", name_);
  return *T;
}

}  // namespace infuse::importers
