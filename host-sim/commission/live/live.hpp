#pragma once
// The live half of `host-sim commission`: heats a wire in a servo on the bus in a guided sequence,
// records it, and asks a person for readings of the displacement.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host-sim/can/remote.hpp"
#include "host-sim/commission/anchor.hpp"
#include "host-sim/commission/live/questions.hpp"
#include "host-sim/commission/live/sequence.hpp"

namespace smaservo::commission {

struct LiveOptions {
  std::string can;  ///< as of `host-sim can --can`
  unsigned node = 1;
  std::optional<std::uint32_t> key;
  double timeout_s = 0.5;  ///< longest wait for an answer

  std::string path;       ///< of the run file
  bool questions = true;  ///< false: nothing is asked
  std::size_t asks = 1;   ///< readings of the heated wire, up to most_questions
  double reading_sd_m = 0.2e-3;
  LevelTimes times{};
  double hold_s = 20;        ///< longest hold of the heat for one question
  double cold_wait_s = 300;  ///< longest wait for the cold reading, without heat
};

struct LiveRun {
  std::string path;
  std::vector<Anchor> anchors;  ///< the first one is the cold reading; empty: none
  std::size_t rows = 0;
  std::size_t left_out = 0;  ///< rows in which a reading failed; they leave gaps in the time
  double period_s = 0;
  double longest_gap_s = 0;
  std::vector<std::string> notes;  ///< what a person should know of this run
};

/// Runs the sequence and writes the run file: time_s, current_A, voltage_V, stress_Pa, and what the
/// servo estimates in columns that begin with servo_. Heat is off when it returns or throws.
/// Throws UserError where the bus, the servo or the wire are not as they must be; no file is then
/// left. SIGINT, SIGTERM and SIGHUP end the heat, and then this program.
LiveRun record_live(const LiveOptions& options);

/// The same with a servo and a person of the caller; the bus's time is the clock. Throws UserError
/// once EndBySignal::came().
LiveRun record_live(const LiveOptions& options, can::Remote& remote, Person& person);

/// The anchors as a table: time_s,displacement_m,sd_m.
std::string anchors_csv(const std::vector<Anchor>& anchors);

}  // namespace smaservo::commission
