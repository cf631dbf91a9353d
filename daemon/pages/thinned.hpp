#pragma once

#include <vector>

namespace infuse::daemon {

/// Keeps at most `kMax` elements of a sequence of unknown length, evenly spread: when it is full,
/// every other element is dropped, and from then on every other one of those that come is kept.
template <class T>
class Thinned {
 public:
  static constexpr size_t kMax = 4000;

  void add(T element) {
    if (count_++ % stride_ != 0) return;
    if (kept_.size() == kMax) {
      for (size_t i = 0; 2 * i < kMax; ++i) kept_[i] = std::move(kept_[2 * i]);
      kept_.resize(kMax / 2);
      stride_ *= 2;
      if ((count_ - 1) % stride_ != 0) return;
    }
    kept_.push_back(std::move(element));
  }

  const std::vector<T>& kept() const { return kept_; }

 private:
  std::vector<T> kept_;
  size_t count_ = 0;
  size_t stride_ = 1;
};

}  // namespace infuse::daemon
