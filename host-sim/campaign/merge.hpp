#pragma once

#include "host-sim/campaign/folder.hpp"

namespace smaservo::campaign {

/// Writes the rows of all chunks into one file, in order. Needs the memory of one chunk. Throws
/// UserError, which names the chunks, if any is missing, broken or of another plan, and if there is
/// a file that is none of them; then no file is written.
void merge(const Campaign& campaign, const Folder& folder);

}  // namespace smaservo::campaign
