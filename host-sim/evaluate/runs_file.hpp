#pragma once
// Judged runs as a CSV file, from which tables of many such files are made.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host-sim/evaluate/evaluate.hpp"

namespace smaservo::evaluate {

/// A judged run, with its place in an evaluation.
struct KeptRun {
  std::string observer;
  std::size_t row;  ///< index in evaluation_rows()
  JudgedRun judged;
};

/// One line for each run of each observer. Numbers have as many digits as it takes to read the same
/// bits again. The last cell counts errors: "0:12 3:5", 12 of them below 0.01 % of the stroke, 5
/// from 0.03 to 0.04 %.
std::string runs_csv(const Evaluation& evaluation);

/// Reads what runs_csv() has written. Throws UserError, which names the line, for other texts.
std::vector<KeptRun> read_runs_csv(std::string_view text);

/// The evaluation of many runs, which are not kept: thousands of units need no more memory than
/// one. Observers and rows are in the order of their first runs.
class JoinedRuns {
 public:
  explicit JoinedRuns(std::vector<hal::Family> families) : families_(std::move(families)) {}

  void add(const KeptRun& run);
  /// Of its runs each row has the one with the greatest mean error, if there is any.
  Evaluation evaluation(int units, std::uint64_t seed) const;

 private:
  struct Row {
    std::size_t row;
    RowSum sum;
    JudgedRun worst;
  };
  struct Observer {
    std::string name;
    std::vector<Row> rows;
  };

  std::vector<hal::Family> families_;
  std::vector<Observer> observers_;
};

}  // namespace smaservo::evaluate
