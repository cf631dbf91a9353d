#pragma once

#include <vector>

namespace infuse::study {

/// The best answer to a query by one method.
struct RankedAnswer {
  double score = 0;
  bool right = false;   ///< within the tolerance of the truth
  bool on_map = false;  ///< there was a right answer
};

/// Precision and recall as the threshold of the score falls. Recall counts the queries on the map.
struct PrecisionRecall {
  double area = 0;            ///< under the curve: precision over recall, by trapezoids
  double recall_at_full = 0;  ///< highest recall without a wrong answer
  double recall = 0;          ///< with every answer accepted
  double precision = 0;       ///< the same
};

PrecisionRecall precision_recall(std::vector<RankedAnswer> answers);

}  // namespace infuse::study
