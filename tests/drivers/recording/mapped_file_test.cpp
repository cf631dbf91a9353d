#include "drivers/recording/mapped_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "drivers/recording/atomic_file.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::recording {
namespace {

TEST(MappedFile, ReadsAtomicallyWrittenFiles) {
  const ScratchFolder folder;
  const std::vector<std::byte> first(100'000, std::byte{7}), second(10, std::byte{9});
  ASSERT_TRUE(write_file_atomically(folder / "x", first));
  const auto mapped = MappedFile::open(folder / "x");
  ASSERT_TRUE(mapped);
  EXPECT_TRUE(std::ranges::equal(mapped->bytes(), first));
  // An existing mapping keeps the old content.
  ASSERT_TRUE(write_file_atomically(folder / "x", second));
  EXPECT_TRUE(std::ranges::equal(mapped->bytes(), first));
  const auto again = MappedFile::open(folder / "x");
  ASSERT_TRUE(again);
  EXPECT_TRUE(std::ranges::equal(again->bytes(), second));
  // No temporary file remains.
  const std::filesystem::path parent = (folder / "x").parent_path();
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(parent), {}), 1);
}

TEST(MappedFile, RejectsMissingFoldersAndEmptyFiles) {
  const ScratchFolder folder;
  EXPECT_FALSE(MappedFile::open(folder / "missing"));
  EXPECT_FALSE(MappedFile::open((folder / "x").parent_path()));
  ASSERT_TRUE(write_file_atomically(folder / "empty", {}));
  EXPECT_FALSE(MappedFile::open(folder / "empty"));
  EXPECT_FALSE(write_file_atomically(folder / "no" / "such" / "folder", {}));
}

TEST(MappedFile, IsMovable) {
  const ScratchFolder folder;
  const std::vector<std::byte> bytes(5000, std::byte{1});
  ASSERT_TRUE(write_file_atomically(folder / "x", bytes));
  auto first = MappedFile::open(folder / "x");
  ASSERT_TRUE(first);
  MappedFile second = std::move(*first);
  EXPECT_TRUE(first->bytes().empty());
  EXPECT_EQ(second.bytes().size(), 5000U);
  second = MappedFile();
  EXPECT_TRUE(second.bytes().empty());
}

}  // namespace
}  // namespace infuse::recording
