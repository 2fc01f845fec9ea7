#pragma once
// What a folder of runs holds, and whether its SHA256SUMS says the same.

#include <set>
#include <string>
#include <vector>

#include "host-sim/record/sums.hpp"

namespace smaservo::record {

struct Contents {
  std::set<std::string> files;  ///< plain files, relative to the folder
  std::vector<Sum> sums;        ///< the lines of SHA256SUMS
  std::vector<std::string> faults;
  std::vector<std::string> notes;  ///< files that are no part of the data set
  /// README.md is missing or has another sum; it can be made again from card and runs.
  std::string readme_fault;
};

/// Reads all files that are listed, and follows no link, so nothing outside is opened.
Contents contents_of(const std::string& path);

/// Whether it is a run's file: "runs/NAME.csv".
bool is_run(const std::string& name);
/// The name of a run in "runs/NAME.csv".
std::string run_of(const std::string& name);
/// "runs/NAME.csv".
std::string path_of_run(const std::string& run);

}  // namespace smaservo::record
