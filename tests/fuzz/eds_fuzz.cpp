// Any text is a data sheet, or refused with a message.

#include "model/files/error.hpp"
#include "tests/can/eds_node/eds_file.hpp"
#include "tests/fuzz/processor_limit.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const smaservo::fuzz::ProcessorLimit limit;
  const std::string_view text(reinterpret_cast<const char*>(data), size);  // NOLINT(*-cast)
  try {
    smaservo::parse_eds(text, "fuzz.eds", 1);
  } catch (const smaservo::files::UserError&) {
    return 0;
  }
  return 0;
}
