#pragma once
// What the ranks of a campaign do together.

#include <exception>
#include <functional>

#include "host-sim/campaign/cluster/ranks.hpp"
#include "host-sim/campaign/run.hpp"

namespace smaservo::campaign {

/// Ends this rank after one of the ranks has printed an error.
class EndedTogether : public std::exception {};

/// Ends this rank since a signal has come to it (EndBySignal). The others are not waited for: they
/// get theirs, or are ended by what has started them.
class EndedBySignal : public std::exception {};

/// Does the work of this rank while the others do theirs, and waits for them. If that of any rank
/// throws, the first one of these prints its error, and EndedTogether is thrown in all. Throws
/// EndedBySignal.
void all_do(Ranks& ranks, const std::function<void()>& work);

/// Like run_campaign(), each rank a shard; gives the counts of all. An error of any rank ends the
/// others between two trials. Progress is that of all ranks, shown by rank 0 alone. What
/// options.stop tells is taken for a signal. Throws EndedBySignal, and what run_campaign() throws
/// in this rank.
RunResult run_together(Ranks& ranks, const Campaign& campaign, const Folder& folder,
                       const RunOptions& options);

}  // namespace smaservo::campaign
