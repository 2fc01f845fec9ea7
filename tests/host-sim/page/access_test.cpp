#include "host-sim/page/access.hpp"

#include <gmock/gmock.h>

#include "model/files/error.hpp"

namespace smaservo::page {
namespace {

const std::string secret(64, 'a');

struct Case {
  const char* listen;
  bool has_token;
  Request request;
  int status;
};

// Loopback without a token: names of this machine, pages of the same host and port.
const Case cases[] = {
    {"127.0.0.1:8765", false, {"127.0.0.1:8765", "", "", ""}, 200},
    {"127.0.0.1:8765", false, {"localhost:8765", "", "", ""}, 200},
    {"127.0.0.1:8765", false, {"LocalHost:8765", "http://localhost:8765", "", ""}, 200},
    {"127.0.0.1:8765", false, {"[::1]:8765", "http://[::1]:8765", "", ""}, 200},
    {"127.0.0.1:8765", false, {"localhost", "http://localhost", "", ""}, 200},
    {"127.1.2.3:8765", false, {"127.1.2.3:8765", "http://127.1.2.3:8765", "", ""}, 200},
    // Through a tunnel whose near end has another port.
    {"127.0.0.1:8765", false, {"localhost:9000", "http://localhost:9000", "", ""}, 200},
    // A foreign name that resolves to this machine.
    {"127.0.0.1:8765", false, {"evil.example:8765", "", "", ""}, 403},
    {"127.0.0.1:8765", false, {"evil.example:8765", "http://evil.example:8765", "", ""}, 403},
    {"127.0.0.1:8765", false, {"localhost.evil.example", "", "", ""}, 403},
    {"127.0.0.1:8765", false, {"127.0.0.1.evil.example:8765", "", "", ""}, 403},
    {"127.0.0.1:8765", false, {"192.168.1.5:8765", "", "", ""}, 403},
    {"127.0.0.1:8765", false, {"127.1.2.3:8765", "", "", ""}, 403},
    // A foreign page.
    {"127.0.0.1:8765", false, {"127.0.0.1:8765", "https://evil.example", "", ""}, 403},
    {"127.0.0.1:8765", false, {"127.0.0.1:8765", "http://127.0.0.1:3000", "", ""}, 403},
    {"127.0.0.1:8765", false, {"127.0.0.1:8765", "http://localhost:8765", "", ""}, 403},
    {"127.0.0.1:8765", false, {"127.0.0.1:8765", "null", "", ""}, 403},
    {"127.0.0.1:8765", false, {"127.0.0.1:8765", "file://", "", ""}, 403},
    {"127.0.0.1:8765",
     false,
     {"127.0.0.1:8765", "http://evil.example/127.0.0.1:8765", "", ""},
     403},
    {"127.0.0.1:8765", false, {"127.0.0.1:8765", "https://allowed.example", "", ""}, 200},
    {"127.0.0.1:8765", false, {"evil.example", "https://allowed.example", "", ""}, 403},
    // The Host header is empty, or is no valid host name.
    {"127.0.0.1:8765", false, {"", "", "", ""}, 400},
    {"127.0.0.1:8765", false, {"localhost\r\nx: y", "", "", ""}, 400},
    {"127.0.0.1:8765", false, {"local host", "", "", ""}, 400},
    {"127.0.0.1:8765", false, {"a@localhost", "", "", ""}, 400},
    {"127.0.0.1:8765", false, {"localhost; script-src *", "", "", ""}, 400},
    // With a token: from everywhere, under any name, but not from a foreign page.
    {"0.0.0.0:8765", true, {"pi.local:8765", "", "", secret}, 200},
    {"0.0.0.0:8765", true, {"pi.local:8765", "http://pi.local:8765", "", secret}, 200},
    {"0.0.0.0:8765", true, {"pi.local:8765", "", "Bearer " + secret, ""}, 200},
    {"0.0.0.0:8765", true, {"pi.local:8765", "", "bearer " + secret, ""}, 200},
    {"0.0.0.0:8765", true, {"pi.local:8765", "http://evil.example", "", secret}, 403},
    {"0.0.0.0:8765", true, {"pi.local:8765", "", "", ""}, 401},
    {"0.0.0.0:8765", true, {"127.0.0.1:8765", "", "", ""}, 401},
    {"0.0.0.0:8765", true, {"pi.local:8765", "", "", std::string(64, 'b')}, 401},
    {"0.0.0.0:8765", true, {"pi.local:8765", "", "", secret.substr(1)}, 401},
    {"0.0.0.0:8765", true, {"pi.local:8765", "", "", secret + "a"}, 401},
    {"0.0.0.0:8765", true, {"pi.local:8765", "", secret, ""}, 401},
    {"0.0.0.0:8765", true, {"pi.local:8765", "", "Basic " + secret, ""}, 401},
    {"127.0.0.1:8765", true, {"127.0.0.1:8765", "", "", ""}, 401},
    {"127.0.0.1:8765", true, {"127.0.0.1:8765", "", "", secret}, 200},
};

TEST(Access, IsWhatTheTableSays) {
  for (const Case& one : cases) {
    const AccessRules rules{.listen = parse_listen(one.listen),
                            .token = one.has_token ? secret : "",
                            .origins = {"https://allowed.example"}};
    const Verdict verdict = judge(rules, one.request);
    EXPECT_EQ(verdict.status, one.status)
        << one.listen << " host '" << one.request.host << "' origin '" << one.request.origin << "'";
    EXPECT_EQ(verdict.why.empty(), verdict.status == 200);
    // No refusal tells the secret.
    EXPECT_EQ(verdict.why.find(secret), std::string::npos);
  }
}

TEST(Access, ComparesWholeTokens) {
  EXPECT_TRUE(equal_in_constant_time(secret, secret));
  EXPECT_FALSE(equal_in_constant_time("", secret));
  for (std::size_t i = 0; i < secret.size(); ++i) {
    std::string other = secret;
    other[i] = 'b';
    EXPECT_FALSE(equal_in_constant_time(other, secret)) << i;
  }
}

TEST(Access, ReadsAddresses) {
  const struct {
    const char* text;
    const char* address;
    std::uint16_t port;
    bool loopback;
  } good[] = {
      {"127.0.0.1:8765", "127.0.0.1", 8765, true}, {"[::1]:80", "::1", 80, true},
      {"localhost:1", "127.0.0.1", 1, true},       {"9000", "127.0.0.1", 9000, true},
      {"127.9.9.9:0", "127.9.9.9", 0, true},       {"0.0.0.0:8765", "0.0.0.0", 8765, false},
      {"[::]:65535", "::", 65535, false},          {"192.168.1.5:1", "192.168.1.5", 1, false},
      {"[fe80::1]:5", "fe80::1", 5, false}};
  for (const auto& one : good) {
    const Listen listen = parse_listen(one.text);
    EXPECT_EQ(listen.address, one.address);
    EXPECT_EQ(listen.port, one.port);
    EXPECT_EQ(listen.loopback, one.loopback) << one.text;
    EXPECT_EQ(parse_listen(listen.text()).text(), listen.text());
  }
  for (const char* text : {"", ":", "127.0.0.1", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:-1",
                           "::1:80", "[127.0.0.1]:80", "[::1]", "example.org:80", "127.1:80",
                           "127.0.0.1:80x", "127.0.0.1: 80", "[]:80", "[::1:80", "1e3"}) {
    EXPECT_THROW(parse_listen(text), files::ConfigError) << text;
  }
}

}  // namespace
}  // namespace smaservo::page
