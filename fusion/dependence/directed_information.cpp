#include "fusion/dependence/directed_information.hpp"

#include <algorithm>
#include <vector>

namespace infuse::dependence {
namespace {

constexpr int kMaxMemory = 16;            // bounds work
constexpr int kMaxSequenceLength = 1024;  // bounds work

/// Numbers words: observations that agree in all labels appended so far have the same number.
class Words {
 public:
  explicit Words(size_t observations) : ids_(observations, 0) {}

  /// Appends the label `label_of(observation)` to every word.
  template <class LabelOf>
  void append(LabelOf label_of) {
    struct Key {
      int32_t word, label;
      size_t observation;
    };
    std::vector<Key> keys(ids_.size());
    for (size_t i = 0; i < ids_.size(); ++i) keys[i] = {ids_[i], label_of(i), i};
    std::sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) {
      return a.word != b.word ? a.word < b.word : a.label < b.label;
    });
    int32_t id = 0;
    for (size_t i = 0; i < keys.size(); ++i) {
      if (i > 0 && (keys[i].word != keys[i - 1].word || keys[i].label != keys[i - 1].label)) ++id;
      ids_[keys[i].observation] = id;
    }
  }

  Estimate entropy(CountEntropyOptions::Estimator estimator) const {
    std::vector<double> counts(ids_.size(), 0.0);
    for (const int32_t id : ids_) counts[static_cast<size_t>(id)] += 1;
    while (!counts.empty() && counts.back() == 0) counts.pop_back();  // unused numbers
    CountEntropyOptions options;
    options.estimator = estimator;
    return infuse::dependence::entropy(counts, options);
  }

 private:
  std::vector<int32_t> ids_;
};

const char* check_estimator(CountEntropyOptions::Estimator estimator) {
  switch (estimator) {
    case CountEntropyOptions::Estimator::kMaximumLikelihood:
    case CountEntropyOptions::Estimator::kMillerMadow:
    case CountEntropyOptions::Estimator::kChaoShen:
      return "";
    case CountEntropyOptions::Estimator::kJamesStein:
      break;
  }
  return "this estimator needs the vocabulary of sequences: use maximum likelihood, Miller-Madow "
         "or Chao-Shen";
}

/// One term of P(6.1): H(after_y) − H(before_y) of words of y, minus the same for words of y and x.
struct Term {
  Estimate y_after, y_before, xy_after, xy_before;

  double value() const {
    return (y_after.value - y_before.value) - (xy_after.value - xy_before.value);
  }
  const char* reason() const {
    for (const Estimate& h : {y_after, y_before, xy_after, xy_before}) {
      if (!h.usable()) return h.reason;
    }
    return "";
  }
};

/// Appends a label of y to the words of y and to those of y and x, and measures what that adds.
template <class LabelOf>
Term append_label(Words& y, Words& xy, LabelOf label_y, CountEntropyOptions::Estimator estimator) {
  Term term;
  term.y_before = y.entropy(estimator);
  term.xy_before = xy.entropy(estimator);
  y.append(label_y);
  xy.append(label_y);
  term.y_after = y.entropy(estimator);
  term.xy_after = xy.entropy(estimator);
  return term;
}

}  // namespace

Estimate directed_information(std::span<const int32_t> x, std::span<const int32_t> y, int length,
                              CountEntropyOptions::Estimator estimator, bool delayed) {
  if (x.size() != y.size()) return {0, "the sides differ in size"};
  if (length < 1 || length > kMaxSequenceLength) return {0, "the length is not between 1 and 1024"};
  const auto steps = static_cast<size_t>(length);
  if (x.empty() || x.size() % steps != 0) return {0, "not a whole number of sequences"};
  if (x.size() > 1u << 30) return {0, "too many samples"};
  if (const char* reason = check_estimator(estimator); *reason) return {0, reason};
  const size_t observations = x.size() / steps;
  if (observations < 2) return {0, "fewer than two sequences: use directed_information_rate"};

  Words past_y(observations), past_xy(observations);
  double sum = 0;
  for (size_t step = 0; step < steps; ++step) {
    const auto label_x = [&](size_t i) { return x[i * steps + step]; };
    const auto label_y = [&](size_t i) { return y[i * steps + step]; };
    if (!delayed) past_xy.append(label_x);
    const Term term = append_label(past_y, past_xy, label_y, estimator);
    if (delayed) past_xy.append(label_x);
    if (*term.reason()) return {0, term.reason()};
    sum += term.value();
  }
  return {sum, ""};
}

Estimate directed_information_rate(std::span<const int32_t> x, std::span<const int32_t> y,
                                   int memory, CountEntropyOptions::Estimator estimator,
                                   bool delayed) {
  if (x.size() != y.size()) return {0, "the sides differ in size"};
  if (memory < 0 || memory > kMaxMemory) return {0, "the memory is not between 0 and 16"};
  if (x.size() > 1u << 30) return {0, "too many samples"};
  if (const char* reason = check_estimator(estimator); *reason) return {0, reason};
  const auto m = static_cast<size_t>(memory);
  if (x.size() < m + 2) return {0, "the sequences are shorter than the memory plus two"};

  const size_t observations = x.size() - m;
  Words words_y(observations), words_xy(observations);
  for (size_t step = 0; step < m; ++step) {
    const auto label_x = [&](size_t i) { return x[i + step]; };
    const auto label_y = [&](size_t i) { return y[i + step]; };
    words_y.append(label_y);
    words_xy.append(label_y);
    words_xy.append(label_x);
  }
  const auto now_x = [&](size_t i) { return x[i + m]; };
  const auto now_y = [&](size_t i) { return y[i + m]; };
  if (!delayed) words_xy.append(now_x);
  const Term term = append_label(words_y, words_xy, now_y, estimator);
  if (*term.reason()) return {0, term.reason()};
  return {term.value(), ""};
}

}  // namespace infuse::dependence
