#pragma once
// What the targets of the readers do with their input. Each may refuse it with the error that a
// program reports; any other exception, a broken property or what a sanitizer finds is a finding.

#include <cstdint>
#include <span>

namespace smaservo::fuzz {

using Input = std::span<const std::uint8_t>;

// Texts.
void wire(Input input);      ///< what is accepted is written and read back to the same text
void settings(Input input);  ///< accepted settings are written and read back to the same text, and
                             ///< pass check(); also changes in a trace's row
void scenario(Input input);  ///< scenarios of a closed loop, and of the sweeps of a plant
void board(Input input);
void actuator(Input input);
void trace(Input input);  ///< all rows of a CSV file, read strictly, leniently, and for a device

/// A file of records; or, behind a first byte that is odd, the lines of a good one: schema, then
/// messages. What is accepted is written and read back to the same rows.
void mcap(Input input);

void recording(Input input);  ///< recordings of the recorder or a step test; accepted ones are
                              ///< written and read back
void mark(Input input);       ///< the mark of the last run, and systemd's result of how it ended

/// Edits of a store's two slots, which are read, and written anew. Of four bytes each: slot and
/// whether its checksum is made right afterwards, position (two), value.
void store(Input input);

/// What nodes answer to host-sim's client: frames of nine bytes each, whose first chooses the
/// identifier. They come as fast as the client asks, then never more.
void client(Input input);

/// A datagram of the bus; or, behind a first byte that is odd, edits of a good one.
void datagram(Input input);

}  // namespace smaservo::fuzz
