#include "tests/study/places/precision_recall.hpp"

#include <algorithm>

namespace infuse::study {

PrecisionRecall precision_recall(std::vector<RankedAnswer> answers) {
  std::stable_sort(answers.begin(), answers.end(),
                   [](const RankedAnswer& a, const RankedAnswer& b) { return a.score > b.score; });
  const auto on_map = static_cast<double>(std::count_if(
      answers.begin(), answers.end(), [](const RankedAnswer& a) { return a.on_map; }));
  PrecisionRecall out;
  if (on_map == 0) return out;
  double right = 0, accepted = 0, last_recall = 0, last_precision = 1;
  for (size_t i = 0; i < answers.size();) {
    const double score = answers[i].score;
    for (; i < answers.size() && answers[i].score == score; ++i) {  // ties stand or fall together
      right += answers[i].right ? 1 : 0;
      accepted += 1;
    }
    out.recall = right / on_map;
    out.precision = right / accepted;
    if (right == accepted) out.recall_at_full = out.recall;
    out.area += (out.recall - last_recall) * (out.precision + last_precision) / 2;
    last_recall = out.recall;
    last_precision = out.precision;
  }
  return out;
}

}  // namespace infuse::study
