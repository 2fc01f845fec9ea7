#include "host-sim/record/contents.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <iterator>
#include <map>

#include "host-sim/record/folder.hpp"
#include "model/files/error.hpp"
#include "model/files/input_file.hpp"

namespace smaservo::record {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view runs_begin = "runs/", csv_end = ".csv";

class Look {
 public:
  explicit Look(const std::string& path) : path_(path) {}

  Contents all() {
    list();
    judge_names();
    judge_listed();
    judge_unlisted();
    return std::move(contents_);
  }

 private:
  std::string shown(const std::string& name) const { return (path_ / name).string(); }
  void fault(const std::string& name, const std::string& what) {
    const std::string text = fmt::format("{}: {}", shown(name), what);
    if (name == readme_name) {
      contents_.readme_fault = contents_.readme_fault.empty() ? text : contents_.readme_fault;
    } else {
      contents_.faults.push_back(text);
    }
  }

  void list() {
    std::error_code error;
    fs::recursive_directory_iterator all(path_, error);
    for (; !error && all != fs::recursive_directory_iterator(); all.increment(error)) {
      const std::string name = all->path().lexically_relative(path_).generic_string();
      const fs::file_status status = all->symlink_status(error);
      if (name == ".git" && fs::is_directory(status)) {
        all.disable_recursion_pending();
      } else if (fs::is_regular_file(status)) {
        contents_.files.insert(name);
      } else if (!fs::is_directory(status)) {
        contents_.faults.push_back(fmt::format(
            "{}: is {}", shown(name),
            fs::is_symlink(status)
                ? "a link; a data set holds its files itself, and the link is not followed"
                : "neither a file nor a folder"));
      }
    }
    if (error) {
      fault("", fmt::format("cannot be read: {}", error.message()));
    }
  }

  void judge_names() {
    std::map<std::string, std::string> seen;
    for (const std::string& name : contents_.files) {
      const auto [other, is_new] = seen.emplace(lower_case(name), name);
      if (!is_new) {
        contents_.faults.push_back(
            fmt::format("{}: is {} in other letters; some systems can hold only one of them",
                        shown(name), other->second));
      }
      if (name.starts_with(runs_begin) && !is_run(name)) {
        fault(name, "is no run that commands read, which is a file runs/NAME.csv");
      }
    }
    for (const char* const needed : {card_name, wire_name, readme_name, sums_name}) {
      if (!contents_.files.contains(needed)) {
        fault(needed, "is missing");
      }
    }
  }

  void judge_listed() {
    if (!contents_.files.contains(sums_name)) {
      return;
    }
    contents_.sums =
        parse_sums(files::whole_file(shown(sums_name)), shown(sums_name), contents_.faults);
    for (const Sum& sum : contents_.sums) {
      if (!listed_.insert(sum.path).second) {
        fault(sums_name, fmt::format("has {} twice", sum.path));
      } else if (!stays_inside(sum.path)) {
        fault(sums_name,
              fmt::format("has {}, which is outside of the folder; it is not read", sum.path));
      } else if (!contents_.files.contains(sum.path)) {
        fault(sum.path, fmt::format("is in {}, and is no file of the folder", sums_name));
      } else {
        compare(sum);
      }
    }
  }

  void compare(const Sum& sum) {
    try {
      const std::string hex = sha256_of_file(shown(sum.path));
      if (hex != sum.hex) {
        fault(sum.path, fmt::format("has changed: its SHA-256 is {}, in {} it is {}", hex,
                                    sums_name, sum.hex));
      }
    } catch (const files::Error& error) {
      contents_.faults.emplace_back(error.what());
    }
  }

  void judge_unlisted() {
    std::set<std::string> parts{card_name, wire_name, readme_name};
    std::ranges::copy_if(contents_.files, std::inserter(parts, parts.end()), is_run);
    for (const std::string& name : parts) {
      if (!listed_.contains(name)) {
        // Also README.md: who takes its line away has changed the list.
        contents_.faults.push_back(fmt::format("{}: is not in {}", shown(name), sums_name));
      }
    }
    for (const std::string& name : contents_.files) {
      if (name != sums_name && !listed_.contains(name) && !parts.contains(name)) {
        contents_.notes.push_back(
            fmt::format("{}: is not in {}, and no part of the data set", shown(name), sums_name));
      }
    }
  }

  fs::path path_;
  Contents contents_;
  std::set<std::string> listed_;
};

}  // namespace

Contents contents_of(const std::string& path) {
  return Look(path).all();
}

bool is_run(const std::string& name) {
  return name.starts_with(runs_begin) && name.ends_with(csv_end) &&
         name.size() > runs_begin.size() + csv_end.size() &&
         name.find('/', runs_begin.size()) == std::string::npos;
}

std::string path_of_run(const std::string& run) {
  return fmt::format("{}{}{}", runs_begin, run, csv_end);
}

std::string run_of(const std::string& name) {
  return name.substr(runs_begin.size(), name.size() - runs_begin.size() - csv_end.size());
}

}  // namespace smaservo::record
