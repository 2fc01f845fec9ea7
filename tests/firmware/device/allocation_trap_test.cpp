#include "tests/firmware/device/allocation_trap.hpp"

#include <atomic>
#include <gtest/gtest.h>
#include <string>
#include <thread>

namespace smaservo::test::allocation_trap_test {
namespace {

TEST(AllocationTrap, CatchesEveryKind) {
  struct alignas(64) Wide {
    char bytes[64];
  };
  void* kept = nullptr;
  const auto caught = [&kept](auto make) {
    const AllocationTrap trap;
    kept = make();
    asm volatile("" : : "r"(kept) : "memory");
    return AllocationTrap::caught();
  };
  EXPECT_EQ(caught([]() -> void* { return nullptr; }), 0);
  EXPECT_EQ(caught([] { return ::operator new(1); }), 1);
  ::operator delete(kept);
  EXPECT_EQ(caught([]() -> void* { return new int[3]; }), 1);
  delete[] static_cast<int*>(kept);
  EXPECT_EQ(caught([]() -> void* { return new Wide; }), 1);
  delete static_cast<Wide*>(kept);
  EXPECT_EQ(caught([]() -> void* { return new std::string(100, 'x'); }), 2);
  delete static_cast<std::string*>(kept);
  EXPECT_FALSE(AllocationTrap::armed()) << "no longer than it lives";
}

TEST(AllocationTrap, IsOfOneThread) {
  std::atomic<bool> may{false};
  int* elsewhere = nullptr;
  std::thread other([&] {
    may.wait(false);
    elsewhere = new int(1);
  });
  {
    const AllocationTrap trap;
    may.store(true);
    may.notify_one();
    other.join();
  }
  EXPECT_NE(elsewhere, nullptr);
  EXPECT_EQ(AllocationTrap::caught(), 0);
  delete elsewhere;
}

}  // namespace
}  // namespace smaservo::test::allocation_trap_test
