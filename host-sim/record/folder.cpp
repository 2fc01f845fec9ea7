#include "host-sim/record/folder.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host-sim/record/contents.hpp"
#include "host-sim/record/run.hpp"
#include "model/files/error.hpp"
#include "model/files/input_file.hpp"
#include "model/files/output_file.hpp"

namespace smaservo::record {

namespace fs = std::filesystem;
using files::UserError;

namespace {

constexpr std::size_t longest_name = 100;

bool is_plain(char c) {
  return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || ('0' <= c && c <= '9') || c == '.' ||
         c == '_' || c == '-' || c == '+';
}

std::string host() {
  std::array<char, HOST_NAME_MAX + 1> name{};
  gethostname(name.data(), name.size() - 1);
  std::string text(name.data());
  std::ranges::replace(text, '/', '_');
  return text;
}

/// Moves a file to a name that nothing has. False: something has it.
bool move_to_free(const fs::path& from, const fs::path& to) {
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) {
    return true;
  }
  if (errno == EINVAL || errno == ENOSYS) {  // the file system cannot do this in one step
    std::error_code ignored;
    if (!fs::exists(fs::symlink_status(to, ignored))) {
      return std::rename(from.c_str(), to.c_str()) == 0;
    }
    errno = EEXIST;
  }
  return false;
}

[[noreturn]] void fail(const std::string& path, const char* what) {
  throw UserError(fmt::format("{}: {}: {}", path, what, std::strerror(errno)));
}

/// The first line in which two texts differ, from 1.
std::size_t first_difference(const std::string& a, const std::string& b) {
  const auto at = std::ranges::mismatch(a, b).in1;
  return 1 + static_cast<std::size_t>(std::count(a.begin(), at, '\n'));
}

/// The path without links, dots and a stroke at its end.
fs::path whole_path(const std::string& path) {
  std::error_code error;
  const fs::path whole = fs::weakly_canonical(fs::absolute(path, error), error).lexically_normal();
  if (error) {
    throw UserError(fmt::format("--out {}: {}", path, error.message()));
  }
  return whole.has_filename() ? whole : whole.parent_path();
}

}  // namespace

std::string name_fault(const std::string& name) {
  if (name.empty() || name.size() > longest_name) {
    return fmt::format("must have 1 to {} characters", longest_name);
  }
  const bool begins = is_plain(name.front()) && name.front() != '.' && name.front() != '-';
  return begins && std::ranges::all_of(name, is_plain)
             ? ""
             : "must be made of the letters a to z and A to Z, digits and . _ - +, and begin with "
               "a letter or a digit";
}

std::string proper_name(const std::string& name) {
  std::string proper;
  for (const char c : name.substr(0, longest_name)) {
    const bool joins = !is_plain(c) && proper.ends_with('-');
    proper += joins ? "" : std::string(1, is_plain(c) ? c : '-');
  }
  const std::size_t begin = proper.find_first_not_of(".-_+");
  return begin == std::string::npos ? "run" : proper.substr(begin);
}

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](char c) {
    return 'A' <= c && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return text;
}

Folder::Folder(const std::string& path, const Card& card) : shown_(path), path_(whole_path(path)) {
  std::error_code error;
  const fs::file_status status = fs::status(path_, error);
  if (status.type() == fs::file_type::not_found) {
    if (fs::is_symlink(fs::symlink_status(path_, error))) {
      throw UserError(fmt::format("--out {}: is a link to nothing", shown_));
    }
    is_new_ = true;
    if (!fs::is_directory(path_.parent_path(), error)) {
      throw UserError(
          fmt::format("--out {}: there is no folder {}", shown_, path_.parent_path().string()));
    }
    return;
  }
  if (!fs::is_directory(status)) {
    throw UserError(
        fmt::format("--out {}: {}", shown_, error ? error.message() : "is a file and no folder"));
  }
  is_new_ = fs::is_empty(path_, error);
  if (error) {
    throw UserError(fmt::format("--out {}: {}", shown_, error.message()));
  }
  if (is_new_ && path_ == fs::current_path(error)) {
    throw UserError(
        fmt::format("--out {}: is the folder that you are in; give the name of a new one", shown_));
  }
  if (!is_new_) {
    open_existing(card);
  }
}

void Folder::abandon() {
  if (!staging_.empty()) {
    std::error_code ignored;
    fs::remove_all(staging_, ignored);
    staging_.clear();
  }
}

void Folder::open_existing(const Card& card) {
  std::error_code error;
  if (!fs::exists(path_ / card_name, error) || !fs::exists(path_ / sums_name, error)) {
    throw UserError(fmt::format(
        "--out {}: holds other files and is no folder of runs, which has {} and {}; give a new "
        "or an empty one",
        shown_, card_name, sums_name));
  }
  if (!fs::is_directory(fs::symlink_status(path_ / runs_name, error))) {
    throw UserError(
        fmt::format("--out {}: has no folder {}, or a link in its place", shown_, runs_name));
  }
  // Some file systems have no lock for folders.
  lock_ = hal::Descriptor(open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (lock_.number() >= 0 && flock(lock_.number(), LOCK_EX | LOCK_NB) != 0 &&
      errno == EWOULDBLOCK) {
    throw UserError(
        fmt::format("--out {}: another host-sim record is adding to it; wait for it", shown_));
  }
  const std::string there = files::whole_file((path_ / card_name).string());
  if (there != card.text) {
    const std::size_t line = first_difference(card.text, there);
    throw UserError(fmt::format(
        "{}:{}: differs from the card of {}, to which runs of the same wire and bench alone are "
        "added; give that card ({}), or another --out",
        card.origin, line, shown_, (fs::path(shown_) / card_name).string()));
  }
  Contents contents = contents_of(shown_);
  if (!contents.faults.empty()) {
    throw UserError(fmt::format(
        "{}; nothing is added to a folder that has changed: `host-sim record --check` names all "
        "that is wrong; a run that is not in {} may be of a call that was killed: remove it",
        contents.faults.front(), sums_name));
  }
  sums_ = std::move(contents.sums);
  readme_changed_ = !contents.readme_fault.empty();
  for (const std::string& file : contents.files) {
    if (is_run(file)) {
      runs_.push_back(run_of(file));
    }
  }
  std::ranges::sort(runs_);
}

std::string Folder::run_path(const std::string& name) const {
  return (path_ / path_of_run(name)).string();
}

void Folder::refuse_taken(const std::string& name) const {
  if (const std::string fault = name_fault(name); !fault.empty()) {
    throw UserError(fmt::format("the name '{}' of a run: {}; give another one: --run {}", name,
                                fault, proper_name(name)));
  }
  for (const std::string& run : runs_) {
    if (lower_case(run) == lower_case(name)) {
      throw UserError(fmt::format(
          "{}: is there already, and nothing is overwritten; give another name: --run NAME",
          (fs::path(shown_) / path_of_run(run)).string()));
    }
  }
}

std::string Folder::free_name() const {
  for (int number = 1;; ++number) {
    const std::string name = fmt::format("run-{:03}", number);
    if (std::ranges::find(runs_, name) == runs_.end()) {
      return name;
    }
  }
}

void Folder::begin() {
  const std::string beside = is_new_ ? path_.string() : (path_ / "new").string();
  std::string name;
  // What a killed program with this number has left may be there, and is nobody's to remove.
  for (long number = getpid(); staging_.empty(); ++number) {
    name = files::partial_path(beside, host(), number);
    if (mkdir(name.c_str(), 0777) == 0) {
      staging_ = name;
    } else if (errno != EEXIST) {
      fail(shown_, "cannot be written");
    }
  }
  if (mkdir((staging_ / runs_name).c_str(), 0777) != 0) {
    fail(shown_, "cannot be written");
  }
}

std::string Folder::staged(const std::string& name) const {
  return (staging_ / name).string();
}

std::string Folder::staged_run(const std::string& name) const {
  return (staging_ / path_of_run(name)).string();
}

void Folder::stage(const std::string& name, const std::string& text) const {
  files::OutputFile file(staged(name));
  file.write(text);
  file.commit();
}

std::vector<Sum> Folder::new_sums(const std::vector<std::string>& new_runs) const {
  std::vector<Sum> sums = sums_;
  if (is_new_) {
    sums = {{"", readme_name},
            {sha256_of_file(staged(card_name)), card_name},
            {sha256_of_file(staged(wire_name)), wire_name}};
  }
  std::ranges::find(sums, readme_name, &Sum::path)->hex = sha256_of_file(staged(readme_name));
  for (const std::string& run : new_runs) {
    sums.push_back({sha256_of_file(staged_run(run)), path_of_run(run)});
  }
  return sums;
}

void Folder::complete(const std::vector<std::string>& new_runs) {
  stage(sums_name, sums_text(new_sums(new_runs)));
  refuse_after_signal(shown_);
  if (is_new_) {
    // Renaming does not replace a folder that holds something, nor a file.
    if (std::rename(staging_.c_str(), path_.c_str()) != 0) {
      fail(shown_, errno == ENOTEMPTY || errno == EEXIST || errno == ENOTDIR
                       ? "somebody else has made it meanwhile; call again to add to it"
                       : "cannot be written");
    }
    staging_.clear();
  } else {
    move_into_place(new_runs);
    abandon();
  }
  if (!files::sync_folder_of(path_.string()) ||
      !files::sync_folder_of((path_ / sums_name).string())) {
    fail(shown_, "is written, but a loss of power may take it back");
  }
}

void Folder::move_into_place(const std::vector<std::string>& new_runs) {
  std::vector<std::string> moved;
  const auto take_back = [&](const std::string& path, const char* what) {
    const int why = errno;
    for (const std::string& run : moved) {
      std::remove(run_path(run).c_str());
    }
    errno = why;
    fail(path, what);
  };
  keep_changed_readme();
  for (const std::string& run : new_runs) {
    if (!move_to_free(staged_run(run), run_path(run))) {
      take_back(run_path(run), "cannot be written");
    }
    moved.push_back(run);
  }
  files::sync_folder_of(run_path(new_runs.front()));
  if (std::rename(staged(sums_name).c_str(), (path_ / sums_name).c_str()) != 0) {
    take_back((path_ / sums_name).string(), "cannot be written");
  }
  // Last: where it stays the old one, the next call makes it anew.
  if (std::rename(staged(readme_name).c_str(), (path_ / readme_name).c_str()) != 0) {
    fail((path_ / readme_name).string(), "the runs are added, but this cannot be written");
  }
}

/// Somebody may have written into it.
void Folder::keep_changed_readme() const {
  const fs::path readme = path_ / readme_name;
  for (int number = 1; readme_changed_; ++number) {
    const std::string kept = fmt::format("{}.old-{}", readme.string(), number);
    if (move_to_free(readme, kept) || errno == ENOENT) {
      return;
    }
    if (errno != EEXIST) {
      fail(readme.string(), "was changed, and cannot be kept under another name");
    }
  }
}

}  // namespace smaservo::record
