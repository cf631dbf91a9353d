#include "tests/study/months/fault.hpp"

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace infuse::study {
namespace {

Fault parse_fault(const std::string& text) {
  std::istringstream stream(text);
  Fault fault;
  if (!(stream >> fault.from)) throw std::invalid_argument("no time in '" + text + "'");
  fault.until = fault.from + 1;
  if (stream.peek() == '-') {
    stream.get();
    if (!(stream >> fault.until)) throw std::invalid_argument("no end in '" + text + "'");
  }
  if (!(stream >> fault.subject >> fault.kind) || fault.until <= fault.from) {
    throw std::invalid_argument("not a fault: '" + text + "'");
  }
  stream >> fault.value;
  return fault;
}

}  // namespace

std::vector<Fault> parse_faults(std::string_view text) {
  std::vector<Fault> faults;
  std::istringstream stream{std::string(text)};
  for (std::string part; std::getline(stream, part, ';');) {
    if (part.find_first_not_of(' ') != std::string::npos) faults.push_back(parse_fault(part));
  }
  return faults;
}

FaultSchedule::FaultSchedule(std::vector<Fault> faults) : faults_(std::move(faults)) {
  std::stable_sort(faults_.begin(), faults_.end(),
                   [](const Fault& a, const Fault& b) { return a.from < b.from; });
}

void FaultSchedule::advance(int64_t second) {
  std::erase_if(present_, [&](const Fault& fault) { return fault.until <= second; });
  begun_.clear();
  for (; next_ < faults_.size() && faults_[next_].from <= second; ++next_) {
    begun_.push_back(faults_[next_]);
    if (faults_[next_].until > second) present_.push_back(faults_[next_]);
  }
}

const Fault* FaultSchedule::find(std::string_view subject, std::string_view kind) const {
  for (const Fault& fault : present_) {
    if (fault.subject == subject && fault.kind == kind) return &fault;
  }
  return nullptr;
}

}  // namespace infuse::study
