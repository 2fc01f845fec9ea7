#include "model/files/output_file.hpp"

#include <array>
#include <chrono>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdexcept>
#include <string>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/utsname.h>
#include <unistd.h>
#include <vector>

#include "model/files/error.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace {
std::function<void(int)> fsync_watcher;  // NOLINT(*-avoid-non-const-global-variables)
}  // namespace

/// In the place of the C library's: what a program makes durable, and when.
// NOLINTNEXTLINE(readability-inconsistent-declaration-parameter-name): the header's is reserved
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
  utsname here{};
  uname(&here);
  return files::partial_path(path, here.nodename, getpid());
}

// Processes of two computers that share a folder may have the same number.
TEST(OutputFile, PartsOfTwoComputersHaveTwoNames) {
  EXPECT_EQ(files::partial_path("out/a.csv", "n1.cluster", 12), "out/a.csv.n1.12.part");
  EXPECT_EQ(files::partial_path("out/a.csv", "", 12), "out/a.csv.12.part");
  const std::string host = std::string(50, 'n') + "123";
  for (std::size_t size = 1; size < 255 - std::string(".12.part").size(); ++size) {
    const std::string name(size, 'a');
    const std::string part = fs::path(files::partial_path("out/" + name, host, 12)).filename();
    EXPECT_LE(part.size(), 255U);
    EXPECT_EQ(part.find("123") != std::string::npos, size <= 243) << "the end of the host's name";
    EXPECT_NE(part, files::partial_path(name, host, 13));
  }
}

TEST(OutputFile, TheLongestNamesCanBeWritten) {
  const TemporaryFolder folder;
  const std::string name(255 - part_of("").size() + std::string(".").size(), 'a');
  EXPECT_EQ(refused(folder / name), "");
  const std::string longer(254 - ("." + std::to_string(getpid()) + ".part").size(), 'b');
  EXPECT_EQ(refused(folder / longer), "");
  EXPECT_THAT(folder.names(), UnorderedElementsAre(name, longer));
}

// The other computer's lock may not be seen: then only age tells.
TEST(OutputFile, LeftOversAreOldAndNobodyHoldsThem) {
  const TemporaryFolder folder;
  const auto aged = [&](const std::string& name) {
    const std::string path = folder.write(name, "half");
    fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::hours(3));
    return path;
  };
  aged("a.csv.n1.12.part");
  aged("a.csv.13.part");
  aged("b.csv.n1.12.part");
  aged("a.csv");
  folder.write("a.csv.n2.12.part", "written a moment ago");
  const int held = open(aged("a.csv.n3.12.part").c_str(), O_WRONLY | O_CLOEXEC);
  ASSERT_EQ(flock(held, LOCK_EX | LOCK_NB), 0);
  const auto is_of_a = [](const std::string& name) { return name.starts_with("a.csv"); };
  files::remove_left_overs(folder.path().string(), is_of_a);
  EXPECT_THAT(folder.names(), UnorderedElementsAre("a.csv", "a.csv.n2.12.part", "a.csv.n3.12.part",
                                                   "b.csv.n1.12.part"));
  close(held);
  files::remove_left_overs(folder.path().string(), is_of_a);
  EXPECT_THAT(folder.names(),
              UnorderedElementsAre("a.csv", "a.csv.n2.12.part", "b.csv.n1.12.part"));
  files::remove_left_overs(folder / "none", is_of_a);
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
