#include "firmware/text/canopen/abort_text.hpp"

#include <algorithm>
#include <array>

namespace smaservo::text {
namespace {

struct AbortText {
  std::uint32_t code;
  std::string_view text;
};

constexpr auto abort_texts = std::to_array<AbortText>({
    {0x05030000, "the toggle bit did not change"},
    {0x05040000, "the node waited too long for the next part"},
    {0x05040001, "unknown SDO command"},
    {0x05040002, "invalid block size"},
    {0x05040003, "invalid sequence number"},
    {0x05040004, "wrong checksum"},
    {0x05040005, "out of memory"},
    {0x06010000, "access not supported"},
    {0x06010001, "cannot be read"},
    {0x06010002, "cannot be written"},
    {0x06020000, "no such object"},
    {0x06040041, "cannot be mapped to a PDO"},
    {0x06040042, "the PDO would be too long"},
    {0x06040043, "contradicts another parameter"},
    {0x06040047, "internal incompatibility"},
    {0x06060000, "hardware error"},
    {0x06070010, "wrong length"},
    {0x06070012, "too long"},
    {0x06070013, "too short"},
    {0x06090011, "no such sub-index"},
    {0x06090030, "value not allowed"},
    {0x06090031, "value too high"},
    {0x06090032, "value too low"},
    {0x06090036, "maximum below minimum"},
    {0x060A0023, "resource not available"},
    {0x08000000, "general error"},
    {0x08000020, "cannot be transferred or stored"},
    {0x08000021, "the access level is too low: see access.key"},
    {0x08000022, "not in the present state of the device"},
    {0x08000023, "no object dictionary"},
    {0x08000024, "no data available"},
});

}  // namespace

std::string_view abort_text(std::uint32_t code) {
  const auto* const found = std::ranges::find(abort_texts, code, &AbortText::code);
  return found == abort_texts.end() ? "" : found->text;
}

}  // namespace smaservo::text
