#pragma once
// What the table of a campaign shows.

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host-sim/campaign/folder.hpp"
#include "model/files/text_table.hpp"

namespace smaservo::campaign {

/// A trial, and its number in the main column.
struct WorstTrial {
  std::uint64_t trial;
  double value;
};

/// How a drawn number goes with the main column.
struct Sensitivity {
  std::string column;
  double correlation;  ///< Spearman's, -1 to 1; NaN if one of both never changes
  /// Whether it is more than three standard deviations from what chance gives.
  bool certain;
};

struct Report {
  std::string main;      ///< name of the main column
  std::uint64_t trials;  ///< of the campaign
  /// Trials that statistics are made of: all of them, or every k-th, so that there is memory for
  /// them.
  std::uint64_t used;
  std::vector<WorstTrial> worst;           ///< at most ten of all trials, the worst first
  std::vector<Sensitivity> sensitivities;  ///< the strongest first
  files::TextTable quantiles;              ///< of each numeric result
  files::TextTable classes;                ///< the main column for each class of each text column
  /// Numbers of the main column, sorted, without infinite ones.
  std::vector<double> sorted;
  /// The kind's own table of all trials; null if the kind has none, or it was not asked for.
  std::unique_ptr<const Table> table;
};

/// Spearman's rank correlation of pairs, of which those with NaN are left out; equal numbers share
/// their mean rank. NaN if there are fewer than two pairs, or all of one kind are equal.
double rank_correlation(const std::vector<double>& x, const std::vector<double>& y);

/// Reads all chunks, which must be whole. Statistics are of at most `most_used` trials. The kind's
/// own table, which takes memory for each trial, is made of no more trials than that unless it is
/// asked for.
Report make_report(const Campaign& campaign, const Folder& folder, bool with_table = false,
                   std::uint64_t most_used = 1'000'000);

/// Tables for a terminal, at most 80 characters wide but for the commands, and for results with
/// long names (of `lot`, and of `evaluate` with several observers).
std::string report_text(const Campaign& campaign, const Report& report);

/// The same as one HTML file, with a histogram. Throws UserError.
void write_report(const std::string& path, const Campaign& campaign, const Report& report);

}  // namespace smaservo::campaign
