#pragma once
// The folder of a campaign's results; README.md lists its files.

#include <cstdint>
#include <string>
#include <vector>

#include "hal/linux/system/descriptor.hpp"
#include "host-sim/campaign/chunk.hpp"

namespace smaservo::campaign {

/// One of several divisions of a campaign: the chunks index, index + count, index + 2 count, ...
struct Shard {
  std::uint64_t index = 0;
  std::uint64_t count = 1;
};

/// "K/N", K from 0 to N-1. Throws UserError.
Shard shard_of(const std::string& text);

class Folder {
 public:
  /// Takes a folder that is of this campaign. Throws UserError if it is of another one, or of none.
  static Folder existing(const Campaign& campaign, const std::string& path);
  /// Like existing(); makes a new folder, and takes an empty one.
  static Folder prepared(const Campaign& campaign, const std::string& path);

  const std::string& path() const { return path_; }
  std::string chunk_path(std::uint64_t number) const;
  std::string trials_path() const;
  /// Where a trial's file is put when all chunks are joined. Makes the folder of these files.
  std::string file_path(const std::string& name) const;
  ChunkFile chunk(const Campaign& campaign, std::uint64_t number) const {
    return read_chunk(campaign, number, chunk_path(number));
  }
  /// The names in the folder of chunks that are neither a chunk's of this campaign nor those of
  /// partial files, sorted.
  std::vector<std::string> strangers(const Campaign& campaign) const;
  /// Removes what killed processes have left of the shard's chunks. A chunk is written within a
  /// second when it is computed, and partial files of the last hour are kept: so none of a process
  /// that lives is removed, even where no locks are seen.
  void remove_left_overs(const Shard& shard) const;
  /// Keeps other processes from the same shard until the result is destroyed. Throws UserError if
  /// one has it. A file system without locks locks nothing: then work is done twice, but nothing
  /// is spoilt, since chunks appear whole and both processes write the same bytes.
  hal::Descriptor lock(const Shard& shard) const;

 private:
  explicit Folder(std::string path) : path_(std::move(path)) {}

  std::string path_;
};

}  // namespace smaservo::campaign
