#include <filesystem>
#include <gmock/gmock.h>

#include "tests/host-sim/program.hpp"

namespace smaservo::test {
namespace {

using testing::HasSubstr;
using Texts = Program::Texts;

// Each of these command lines ends the program with a message that names the mistake. No file is
// written.
TEST(PageCommand, MistakesEndItWithAMessage) {
  const struct {
    Texts options;
    int status;
    const char* says;
  } wrong[] = {
      {{}, 2, "--can"},
      {{"--can", "udp", "--key", "key.pem"}, 2, "--certificate"},
      {{"--can", "udp", "--certificate", "certificate.pem"}, 2, "--key"},
      {{"--can", "udp", "--clients", "0"}, 2, "--clients"},
      {{"--can", "udp", "--sync", "-1"}, 2, "--sync"},
      {{"--can", "udp", "--watch", "61"}, 2, "--watch"},
      {{"--can", "udp", "--patience", "3"}, 2, "--patience"},
      {{"--can", "udp", "--units", "SI"}, 2, "--units"},
      {{"--can", "udp", "--timeout", "0"}, 2, "--timeout"},
      {{"--can", "udp", "--listen", "example.org:80"}, 1, "must be ADDRESS:PORT"},
      {{"--can", "udp", "--listen", "127.0.0.1:99999"}, 1, "must be ADDRESS:PORT"},
      {{"--can", "udp", "--token-file", "no/such/\x1B[2J/token"}, 1, "\\x1B[2J"},
      {{"--can", "no-such-bus", "--listen", "127.0.0.1:0"}, 1, "no-such-bus"},
  };
  for (const auto& one : wrong) {
    Program program;
    program.folder().write("no", "a file where a folder is wanted");
    Texts words = one.options;
    words.insert(words.begin(), "page");
    const Finished finished = program.run(words);
    EXPECT_EQ(finished.status, one.status) << finished.err;
    EXPECT_THAT(finished.err, HasSubstr(one.says));
    EXPECT_THAT(finished.out, testing::IsEmpty());
    EXPECT_THAT(program.folder().names(), testing::ElementsAre("no"));
  }
}

TEST(PageCommand, ATokenThatOthersReadIsRefused) {
  Program program;
  const std::string token = program.folder().write("token", std::string(64, 'a'));
  std::filesystem::permissions(token, std::filesystem::perms::others_read,
                               std::filesystem::perm_options::add);
  const Finished finished =
      program.run({"page", "--can", "udp", "--listen", "0.0.0.0:0", "--token-file", token});
  EXPECT_EQ(finished.status, 1);
  EXPECT_THAT(finished.err, HasSubstr("others may read"));
}

}  // namespace
}  // namespace smaservo::test
