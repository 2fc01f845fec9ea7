#pragma once
// The folder of a data set on the disk. It is made beside and renamed, so that it is there whole or
// not at all; runs that are added are made in a folder inside it and moved to their places last.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hal/linux/system/descriptor.hpp"
#include "host-sim/record/card/card.hpp"
#include "host-sim/record/sums.hpp"

namespace smaservo::record {

inline constexpr const char* card_name = "card.toml";
inline constexpr const char* wire_name = "wire.toml";
inline constexpr const char* runs_name = "runs";
inline constexpr const char* readme_name = "README.md";
inline constexpr const char* sums_name = "SHA256SUMS";

/// "" or why a run cannot have this name.
std::string name_fault(const std::string& name);
/// A similar name that a run can have.
std::string proper_name(const std::string& name);

/// For names that differ at most in the case of their letters: some systems take them for one.
std::string lower_case(std::string text);

class Folder {
 public:
  /// A new folder, an empty one, or one with this very card, which is then locked against other
  /// programs and whose files, README.md apart, must be as SHA256SUMS has them. Throws UserError
  /// otherwise. Nothing is written.
  Folder(const std::string& path, const Card& card);
  ~Folder() { abandon(); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  const std::string& path() const { return shown_; }
  bool is_new() const { return is_new_; }
  /// The runs that are there, sorted.
  const std::vector<std::string>& runs() const { return runs_; }
  std::string run_path(const std::string& name) const;

  /// Throws UserError for a name that a run has, in any case of its letters, or cannot have.
  void refuse_taken(const std::string& name) const;
  /// The first of run-001, run-002, ... that is not taken.
  std::string free_name() const;

  /// Where the new files are made. To be called before staged().
  void begin();
  std::string staged(const std::string& name) const;
  std::string staged_run(const std::string& name) const;
  /// Writes a text as a whole file among the new ones.
  void stage(const std::string& name, const std::string& text) const;
  /// Writes SHA256SUMS and moves all that was staged to its place. Throws UserError, also after a
  /// signal (EndBySignal); then the runs are as before.
  void complete(const std::vector<std::string>& new_runs);
  /// Removes what was begun and not completed.
  void abandon();

 private:
  void open_existing(const Card& card);
  void move_into_place(const std::vector<std::string>& new_runs);
  void keep_changed_readme() const;
  std::vector<Sum> new_sums(const std::vector<std::string>& new_runs) const;

  std::string shown_;           ///< as given
  std::filesystem::path path_;  ///< without links
  bool is_new_ = false;
  std::vector<std::string> runs_;
  std::filesystem::path staging_;  ///< empty: not begun
  std::vector<Sum> sums_;          ///< of the files that are there, which have been compared
  bool readme_changed_ = false;
  hal::Descriptor lock_;
};

}  // namespace smaservo::record
