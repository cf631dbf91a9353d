#pragma once

#include <cstdint>
#include <cstdio>
#include <optional>

namespace infuse::recording {

/// Finds records in a pcap file behind one whose length cannot be.
class RecordScan {
 public:
  /// For an open pcap file that can be positioned; its position is kept. Nothing: it is another
  /// kind of file, or compressed.
  static std::optional<RecordScan> of(FILE* file);

  /// Positions the file at the next record, and returns its place: one that follows `damaged`, has
  /// a possible length and a time near those before, and is followed by another such record.
  /// Nothing: there is none within a mebibyte.
  std::optional<int64_t> find_next(FILE* file, int64_t damaged) const;

 private:
  bool swapped_ = false;       ///< numbers have the other byte order
  uint32_t max_fraction_ = 0;  ///< of a second
  uint32_t first_second_ = 0;  ///< of the first record
};

}  // namespace infuse::recording
