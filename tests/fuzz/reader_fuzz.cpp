// All that differs between the targets of the readers: SMASERVO_FUZZ names the function.

#include "readers.hpp"
#include "tests/fuzz/processor_limit.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const smaservo::fuzz::ProcessorLimit limit;
  smaservo::fuzz::SMASERVO_FUZZ({data, size});
  return 0;
}
