#include "firmware/daemon/service/guard.hpp"

#include <gtest/gtest.h>

namespace smaservo::test::guard_test {
namespace {

// A loop that hangs for 8 s costs one switching off, at the first look after its lease.
TEST(LeaseWatch, EachLeaseThatRunsOutIsRevokedOnce) {
  constexpr std::int64_t ms = 1'000'000;
  daemon::LeaseWatch watch;
  int revoked = 0;
  for (std::int64_t now_ns = 0; now_ns < 16'000 * ms; now_ns += 2 * ms) {
    // Renewed for 10 ms at 0 s and at 8 s.
    const std::int64_t renewed_ns = now_ns < 8'000 * ms ? 0 : 8'000 * ms;
    const bool is_out = watch.has_run_out(renewed_ns + 10 * ms, now_ns);
    revoked += is_out ? 1 : 0;
    EXPECT_EQ(is_out, now_ns == renewed_ns + 12 * ms) << now_ns;
  }
  EXPECT_EQ(revoked, 2);
}

TEST(LeaseWatch, WithoutALeaseThereIsNothingToRevoke) {
  daemon::LeaseWatch watch;
  EXPECT_FALSE(watch.has_run_out(0, 1'000'000'000));
  EXPECT_FALSE(watch.has_run_out(1000, 1000));
  EXPECT_TRUE(watch.has_run_out(1000, 1001));
}

}  // namespace
}  // namespace smaservo::test::guard_test
