#pragma once
// A chunk is a file with the rows of consecutive trials and then the files that they leave. Its
// first lines say of which plan it is, its last line proves that it is whole.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/campaign/plan.hpp"

namespace smaservo::campaign {

enum class ChunkState : unsigned char {
  missing,
  whole,
  broken,  ///< cut off or changed
  foreign  ///< of another plan or version, or of other trials than its name says
};

struct ChunkFile {
  ChunkState state;
  std::string problem;             ///< what is wrong with it, for a person
  std::string text;                ///< the file's content
  std::size_t begin = 0, end = 0;  ///< where its rows are in `text`

  std::string_view rows() const { return std::string_view(text).substr(begin, end - begin); }
  /// The files that its trials leave.
  std::vector<TrialFile> files() const;
};

/// The file's content, from the results of all its trials.
std::string chunk_text(const Campaign& campaign, std::uint64_t number,
                       const std::vector<TrialResult>& results);

/// Reads a file and judges it. Throws ConfigError if it exists and cannot be read.
ChunkFile read_chunk(const Campaign& campaign, std::uint64_t number, const std::string& path);

}  // namespace smaservo::campaign
