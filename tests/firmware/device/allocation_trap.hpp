#pragma once
// Counts what a thread takes from the heap. allocation_trap.cpp replaces malloc in the program that
// it is linked into, so its tests are a program of their own.

namespace smaservo::test {

/// Counts what this thread allocates as long as it lives; one at a time.
class AllocationTrap {
 public:
  AllocationTrap();
  AllocationTrap(const AllocationTrap&) = delete;
  AllocationTrap& operator=(const AllocationTrap&) = delete;
  ~AllocationTrap();

  /// Number of allocations that this thread's present trap has counted; without one, those of its
  /// last trap.
  static int caught();
  static bool armed();
};

}  // namespace smaservo::test
