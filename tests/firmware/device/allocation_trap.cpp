#include "tests/firmware/device/allocation_trap.hpp"

#include <cstddef>

namespace smaservo::test {
namespace {

struct TrapState {
  bool armed;
  int caught;
};
TrapState& trap_state() {
  thread_local TrapState state{};
  return state;
}

void allocating() {
  trap_state().caught += trap_state().armed ? 1 : 0;
}

}  // namespace

AllocationTrap::AllocationTrap() {
  trap_state() = {true, 0};
}
AllocationTrap::~AllocationTrap() {
  trap_state().armed = false;
}
int AllocationTrap::caught() {
  return trap_state().caught;
}
bool AllocationTrap::armed() {
  return trap_state().armed;
}

}  // namespace smaservo::test

// The sanitizer has an allocator of its own, with a place to listen. Otherwise the C library's
// functions, which operator new calls, are replaced.
#ifdef SMASERVO_SANITIZED
extern "C" int listen_to_allocator(
    void (*allocated)(const volatile void*, std::size_t),
    void (*freed)(const volatile void*)) asm("__sanitizer_install_malloc_and_free_hooks");
namespace smaservo::test {
namespace {
void heard(const volatile void* /*block*/, std::size_t /*size*/) {
  allocating();
}
void heard_free(const volatile void* /*block*/) {}
const int listening = listen_to_allocator(heard, heard_free);
}  // namespace
}  // namespace smaservo::test
#else
extern "C" {
void* c_library_malloc(std::size_t size) asm("__libc_malloc");
void* c_library_calloc(std::size_t count, std::size_t size) asm("__libc_calloc");
void* c_library_realloc(void* block, std::size_t size) asm("__libc_realloc");
void* c_library_memalign(std::size_t alignment, std::size_t size) asm("__libc_memalign");

void* malloc(std::size_t size) noexcept {
  smaservo::test::allocating();
  return c_library_malloc(size);
}
void* calloc(std::size_t nmemb, std::size_t size) noexcept {
  smaservo::test::allocating();
  return c_library_calloc(nmemb, size);
}
void* realloc(void* ptr, std::size_t size) noexcept {
  smaservo::test::allocating();
  return c_library_realloc(ptr, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  smaservo::test::allocating();
  return c_library_memalign(alignment, size);
}
}
#endif
