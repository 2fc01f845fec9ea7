#include "model/files/output_file.hpp"

#include <array>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdexcept>
#include <string>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <vector>

#include "model/files/error.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace {
std::function<void(int)> fsync_watcher;  // NOLINT(*-avoid-non-const-global-variables)
}  // namespace

/// In the place of the C library's: what a program makes durable, and when.
extern "C" int fsync(int file) {
  if (fsync_watcher) {
    fsync_watcher(file);
  }
  return static_cast<int>(syscall(SYS_fsync, file));
}

namespace smaservo::test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

std::string refused(const std::string& path) {
  try {
    files::OutputFile file(path);
    file.write("text");
    file.commit();
  } catch (const files::UserError& error) {
    return error.what();
  }
  return "";
}

/// The superuser may write anywhere; as long as this lives, it is nobody. Others stay who they are.
class WithoutPrivileges {
 public:
  WithoutPrivileges() : user_(geteuid()) {
    if (user_ == 0 && seteuid(65534) != 0) {
      throw std::runtime_error("cannot give up the superuser's rights");
    }
  }
  WithoutPrivileges(const WithoutPrivileges&) = delete;
  WithoutPrivileges& operator=(const WithoutPrivileges&) = delete;
  ~WithoutPrivileges() {
    if (seteuid(user_) != 0) {
      ADD_FAILURE() << "the user's rights did not come back";
    }
  }

 private:
  uid_t user_;
};

TEST(OutputFile, AppearsWhenItIsComplete) {
  const TemporaryFolder folder;
  const std::string path = folder / "out.csv";
  files::OutputFile file(path);
  file.write("one,");
  file.write(std::string(100'000, 'x'));
  EXPECT_FALSE(fs::exists(path));
  file.commit();
  EXPECT_EQ(file_text(path), "one," + std::string(100'000, 'x'));
  EXPECT_THAT(folder.names(), ElementsAre("out.csv"));
}

TEST(OutputFile, LeavesNothingBehindWhenItIsAbandoned) {
  const TemporaryFolder folder;
  const auto abandon = [&] {
    files::OutputFile file(folder / "out.csv");
    file.write("half");
    throw std::runtime_error("something else");
  };
  EXPECT_THROW(abandon(), std::runtime_error);
  EXPECT_THAT(folder.names(), IsEmpty());
}

TEST(OutputFile, TheOldFileStaysUntilTheNewOneIsComplete) {
  const TemporaryFolder folder;
  const std::string path = folder.write("out.csv", "old");
  {
    files::OutputFile file(path);
    file.write("new, but not complete");
    EXPECT_EQ(file_text(path), "old");
  }
  EXPECT_EQ(file_text(path), "old");
  files::OutputFile file(path);
  file.write("new");
  file.commit();
  EXPECT_EQ(file_text(path), "new");
  EXPECT_THAT(folder.names(), ElementsAre("out.csv"));
}

TEST(OutputFile, SaysWhatCannotBeWrittenAndWhy) {
  const TemporaryFolder folder;
  const std::string file = folder.write("file", "kept");
  fs::create_directory(folder / "folder");
  const std::string missing = folder / "missing/out.csv";
  EXPECT_EQ(refused(missing), missing + ": cannot be written: No such file or directory");
  EXPECT_EQ(refused(file + "/out.csv"), file + "/out.csv: cannot be written: Not a directory");
  EXPECT_EQ(refused(folder / "folder"), folder / "folder" + ": cannot be written: Is a directory");
  EXPECT_THAT(folder.names(), UnorderedElementsAre("file", "folder"));
  EXPECT_EQ(file_text(file), "kept");
}

TEST(OutputFile, NeedsAFolderThatMayBeWritten) {
  const TemporaryFolder folder;
  using enum fs::perms;
  fs::permissions(folder.path(), owner_read | owner_exec | others_read | others_exec);
  const std::string path = folder / "out.csv";
  {
    const WithoutPrivileges nobody;
    EXPECT_EQ(refused(path), path + ": cannot be written: Permission denied");
  }
  fs::permissions(folder.path(), fs::perms::owner_all);
  EXPECT_THAT(folder.names(), IsEmpty());
}

std::string part_of(const std::string& path) {
  return path + "." + std::to_string(getpid()) + ".part";
}

// A program that was killed while it wrote leaves its part. In a container every program is
// process 1: the next one has the same number.
TEST(OutputFile, WhatAKilledProgramHasLeftIsInNobodysWay) {
  const TemporaryFolder folder;
  const std::string path = folder / "out.csv";
  std::ofstream(part_of(path)) << "half, and longer than what follows";
  EXPECT_EQ(refused(path), "");
  EXPECT_EQ(file_text(path), "text");
  EXPECT_THAT(folder.names(), ElementsAre("out.csv"));
}

TEST(OutputFile, TwoThatWriteTheSameFileDoNotMix) {
  const TemporaryFolder folder;
  const std::string path = folder / "out.csv";
  {
    files::OutputFile first(path);
    first.write("first");
    EXPECT_EQ(refused(path), path + ": cannot be written: is being written at the same time");
    first.commit();
  }
  EXPECT_EQ(file_text(path), "first");
  EXPECT_THAT(folder.names(), ElementsAre("out.csv"));
}

TEST(OutputFile, APartThatIsALinkIsNotFollowed) {
  const TemporaryFolder folder;
  const std::string path = folder / "out.csv";
  const std::string other = folder.write("other", "kept");
  fs::create_symlink("other", part_of(path));
  EXPECT_EQ(refused(path), "");
  EXPECT_EQ(file_text(other), "kept");
  EXPECT_EQ(file_text(path), "text");
  EXPECT_THAT(folder.names(), UnorderedElementsAre("other", "out.csv"));
}

// The kernel's calls in their order: what is named must be whole, and the name itself durable.
TEST(OutputFile, IsDurableWithItsName) {
  const TemporaryFolder folder;
  const std::string path = folder / "out.csv";
  std::vector<std::string> synced;
  fsync_watcher = [&](int file) {
    std::array<char, 4096> name{};
    const std::string link = "/proc/self/fd/" + std::to_string(file);
    const ssize_t size = readlink(link.c_str(), name.data(), name.size());
    synced.emplace_back(name.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
    synced.back() += fs::exists(path) ? " renamed" : " beside";
  };
  EXPECT_EQ(refused(path), "");
  fsync_watcher = nullptr;
  EXPECT_THAT(synced, ElementsAre(part_of(path) + " beside", folder.path().string() + " renamed"));
}

TEST(OutputFile, APipeIsWrittenToAndNotReplaced) {
  const TemporaryFolder folder;
  const std::string path = folder / "pipe";
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  const int reader = open(path.c_str(), O_RDWR | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  {
    files::OutputFile file(path);
    file.write("text");
    file.commit();
  }
  EXPECT_TRUE(fs::is_fifo(path)) << "so it would be with /dev/null, too";
  char text[5] = {};
  EXPECT_EQ(read(reader, text, 4), 4);
  EXPECT_STREQ(text, "text");
  close(reader);
  EXPECT_THAT(folder.names(), ElementsAre("pipe"));
}

TEST(OutputFile, ALinkStaysALink) {
  const TemporaryFolder folder;
  const std::string target = folder.write("target.csv", "old");
  fs::create_symlink("target.csv", folder / "link.csv");
  files::OutputFile file(folder / "link.csv");
  file.write("new");
  file.commit();
  EXPECT_TRUE(fs::is_symlink(folder / "link.csv"));
  EXPECT_EQ(file_text(target), "new");
}

TEST(OutputFile, AMinusIsStandardOutput) {
  const TemporaryFolder folder;
  const fs::path before = fs::current_path();
  fs::current_path(folder.path());
  ::testing::internal::CaptureStdout();
  files::OutputFile file("-");
  file.write("to the terminal");
  file.commit();
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "to the terminal");
  fs::current_path(before);
  EXPECT_THAT(folder.names(), IsEmpty());
}

}  // namespace
}  // namespace smaservo::test
