// Every fuzzer on its seeds, on these cut and changed, and on the inputs of tests/fuzz/regressions,
// which once failed. Under the address sanitizer; what libFuzzer finds beyond is ./dev fuzz.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "tests/folders.hpp"
#include "tests/scratch_folder.hpp"

#define INFUSE_FUZZER(name) extern "C" int name(const uint8_t* data, size_t size);
#include "fuzzers.inc"
#undef INFUSE_FUZZER

namespace infuse::fuzz {
namespace {

namespace fs = std::filesystem;

struct Fuzzer {
  std::string name;
  int (*run)(const uint8_t* data, size_t size);
};

void PrintTo(const Fuzzer& fuzzer, std::ostream* out) { *out << fuzzer.name; }

std::vector<Fuzzer> fuzzers() {
  return {
#define INFUSE_FUZZER(name) {#name, &name},
#include "fuzzers.inc"
#undef INFUSE_FUZZER
  };
}

/// Runs `input`, half and nearly all of it, and copies with some other bytes.
void run_variants(const Fuzzer& fuzzer, const std::string& input, std::mt19937& random) {
  constexpr int kChangedCopies = 16, kChanges = 3;
  const auto run = [&](const std::string& bytes) {
    // A copy of exactly this size, so that the sanitizer sees a read beyond its end.
    const std::vector<uint8_t> exact(bytes.begin(), bytes.end());
    fuzzer.run(exact.data(), exact.size());
  };
  run(input);
  if (input.empty()) return;
  run(input.substr(0, input.size() / 2));
  run(input.substr(0, input.size() - 1));
  for (int copy = 0; copy < kChangedCopies; ++copy) {
    std::string changed = input;
    for (int k = 0; k < kChanges; ++k)
      changed[random() % changed.size()] = static_cast<char>(random());
    run(changed);
  }
}

class FuzzCorpus : public testing::TestWithParam<Fuzzer> {
 protected:
  static void SetUpTestSuite() {
    scratch_ = std::make_unique<ScratchFolder>();
    // Some seeds are files of the sources.
    const std::string command = "cd '" + source_folder() + "' && '" + programs_folder() +
                                "/fuzz_seeds' '" + scratch_->path().string() + "'";
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
  }
  static void TearDownTestSuite() { scratch_.reset(); }

  static std::vector<fs::path> inputs(const std::string& fuzzer) {
    std::vector<fs::path> files;
    for (const fs::path& folder :
         {scratch_->path(), fs::path(source_folder()) / "tests/fuzz/regressions"}) {
      if (!fs::exists(folder / fuzzer)) continue;
      for (const auto& entry : fs::directory_iterator(folder / fuzzer))
        files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    return files;
  }

  static std::unique_ptr<ScratchFolder> scratch_;
};

std::unique_ptr<ScratchFolder> FuzzCorpus::scratch_;

TEST_P(FuzzCorpus, IsRead) {
  const auto files = inputs(GetParam().name);
  ASSERT_FALSE(files.empty()) << "fuzz_seeds writes no seed for " << GetParam().name;
  std::mt19937 random(1);
  for (const fs::path& file : files) {
    std::cout << file.string() << std::endl;  // the last one is what a crash is about
    std::ifstream stream(file, std::ios::binary);
    run_variants(GetParam(), std::string(std::istreambuf_iterator<char>(stream), {}), random);
  }
}

INSTANTIATE_TEST_SUITE_P(All, FuzzCorpus, testing::ValuesIn(fuzzers()),
                         [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace infuse::fuzz
