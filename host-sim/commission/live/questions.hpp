#pragma once
// Readings that a person types while the wire is held. Time is an input.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/commission/anchor.hpp"

namespace smaservo::commission {

/// Whoever answers: before the terminal, or in a browser. A function may throw, which ends the run.
class Person {
 public:
  virtual ~Person() = default;

  /// Whether questions are answered at all.
  virtual bool is_there() = 0;
  /// A line that replaces the one before.
  virtual void show(std::string_view line) = 0;
  /// A line that stays.
  virtual void say(std::string_view line) = 0;
  /// Begins a question: forgets what was typed before it, and leaves the cursor behind it. It ends
  /// at this time of the bus.
  virtual void ask(std::string_view question, std::int64_t until_us) = 0;
  /// The next line that was typed since; does not wait.
  virtual std::optional<std::string> typed() = 0;
  /// What became of the line that typed() returned last: taken as a reading or as none, or why not.
  virtual void answered(std::string_view objection) {
    if (!objection.empty()) {
      say(objection);
    }
  }
};

/// A reading as typed: "3.4", "3,4", "3.4 mm". Nothing: not one.
std::optional<double> reading_mm(std::string_view typed);

/// The readings of a run. Scales may grow or fall as the wire contracts: the sign is that of the
/// first reading of the hot wire, which can only be shorter than the cold one.
class Readings {
 public:
  Readings(double sd_m, double wire_m) : sd_m_(sd_m), wire_m_(wire_m) {}

  /// Takes a reading at this time of the run; the first one is of the cold wire. If it cannot be,
  /// nothing is taken, and the text says why.
  std::string take(double time_s, double reading_m);
  bool has_zero() const { return !anchors_.empty(); }
  const std::vector<Anchor>& anchors() const { return anchors_; }

 private:
  double sd_m_, wire_m_;
  double zero_m_ = 0, sign_ = 0;
  std::vector<Anchor> anchors_;
};

/// One question, until it is answered or its time is over.
class Question {
 public:
  Question(Person& person, Readings& readings, std::int64_t until_us)
      : person_(person), readings_(readings), until_us_(until_us) {}

  /// To be called often; true: the question is over. `time_s` is the run's.
  bool look(std::int64_t now_us, double time_s);

 private:
  void ask();

  Person& person_;
  Readings& readings_;
  std::int64_t until_us_;
  bool asked_ = false;
};

}  // namespace smaservo::commission
