#include "host-sim/page/token_file.hpp"

#include <filesystem>
#include <gmock/gmock.h>
#include <set>
#include <sys/stat.h>
#include <thread>
#include <vector>

#include "model/files/error.hpp"
#include "tests/hal/replay/temporary_folder.hpp"

namespace smaservo::page {
namespace {

namespace fs = std::filesystem;

TEST(TokenFile, IsMadeForItsOwnerAndKept) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "state/smaservo/token";
  const mode_t before = umask(0);
  const std::string token = token_of(path);
  umask(before);
  EXPECT_EQ(token.size(), 64U);
  EXPECT_EQ(fs::status(path).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(token_of(path), token);
  EXPECT_EQ(test::file_text(path), token + "\n");
  EXPECT_EQ(std::distance(fs::directory_iterator(fs::path(path).parent_path()), {}), 1);
}

TEST(TokenFile, IsAnotherOneEachTime) {
  std::set<std::string> all;
  for (int i = 0; i < 100; ++i) {
    all.insert(random_token());
  }
  EXPECT_EQ(all.size(), 100U);
}

TEST(TokenFile, IsOneForServersThatStartTogether) {
  const test::TemporaryFolder folder;
  std::vector<std::string> tokens(8);
  {
    std::vector<std::jthread> threads;
    threads.reserve(tokens.size());
    for (std::string& token : tokens) {
      threads.emplace_back([&] { token = token_of(folder / "token"); });
    }
  }
  for (const std::string& token : tokens) {
    EXPECT_EQ(token, tokens[0]);
  }
  EXPECT_THAT(folder.names(), testing::ElementsAre("token"));
}

TEST(TokenFile, ThatIsNotSafeIsRefused) {
  const test::TemporaryFolder folder;
  const std::string good(40, 'x');
  const auto file = [&](const char* name, const std::string& text, fs::perms permissions) {
    const std::string path = folder.write(name, text);
    fs::permissions(path, permissions);
    return path;
  };
  const auto mine = fs::perms::owner_read | fs::perms::owner_write;
  EXPECT_EQ(token_of(file("good", good + "\n", mine)), good);
  EXPECT_THROW(token_of(file("group", good, mine | fs::perms::group_read)), files::UserError);
  EXPECT_THROW(token_of(file("all", good, mine | fs::perms::others_read)), files::UserError);
  EXPECT_THROW(token_of(file("written", good, mine | fs::perms::group_write)), files::UserError);
  EXPECT_THROW(token_of(file("empty", "", mine)), files::UserError);
  EXPECT_THROW(token_of(file("short", std::string(31, 'x'), mine)), files::UserError);
  EXPECT_THROW(token_of(file("long", std::string(257, 'x'), mine)), files::UserError);
  EXPECT_THROW(token_of(file("lines", good + "\n" + good, mine)), files::UserError);
  EXPECT_THROW(token_of(file("signs", good + "&x=1", mine)), files::UserError);
  EXPECT_THROW(token_of(file("zero", good + std::string(1, '\0'), mine)), files::UserError);
  EXPECT_THROW(token_of(folder.path().string()), files::UserError);
  fs::create_symlink(folder / "good", folder / "link");
  EXPECT_THROW(token_of(folder / "link"), files::UserError);
  EXPECT_THROW(token_of(folder / "good/below"), files::UserError);
}

}  // namespace
}  // namespace smaservo::page
