#pragma once
// Changes of parameters: staged one by one, checked as a set, in force as a set. A trial is in
// force for a time and goes back by itself unless it is committed.
//
//   stage, stage, apply                  in force, and what will be stored
//   stage, stage, try_for(30 s), commit  in force at once, stored when committed
//   stage, try_for(30 s), nothing        after 30 s as before
//
// Where one thread does all, this is what owns the settings in force: whoever else uses them keeps
// the number of changes() that it has followed. Where several threads use them their owner is
// another (ParameterDesk of the daemon), which gives them by replace() and is given active().
//
// Not for the loop: apply() and try_for() cost some ten microseconds on a PC. tick() is.

#include "firmware/parameters/parameter_check.hpp"

namespace smaservo {

enum class StageResult : std::uint8_t {
  ok,
  unknown_parameter,
  not_finite,
  below,          ///< its least value
  above,          ///< its greatest value
  while_enabled,  ///< may change without current only
};

enum class ApplyProblem : std::uint8_t {
  none,
  refused,        ///< the set is out of range or contradictory: see the finding
  while_enabled,  ///< the device has been enabled since: a staged parameter may not change now
  only_live,      ///< a trial takes parameters that may change at any time
  on_trial,       ///< commit() or revert() comes first
  no_trial,       ///< there is nothing to commit
  duration,       ///< of a trial: 0.1 s to an hour
};

struct Applied {
  ApplyProblem problem = ApplyProblem::none;
  std::size_t parameter = no_parameter;  ///< the first that may not change
  Finding finding{};

  constexpr bool ok() const { return problem == ApplyProblem::none; }
};

template <class S>
class Staging {
 public:
  /// `settings` have passed check(); after a start they are also those in force.
  explicit Staging(const Settings<S>& settings)
      : active_(settings), configured_(settings), staged_(settings) {}

  /// In force. Changes in apply(), try_for(), revert(), tick() and replace() only, and then as a
  /// whole.
  const Settings<S>& active() const { return active_; }
  /// Counts up with each set that comes into force.
  std::uint32_t changes() const { return changes_; }
  /// What is to be stored: without a trial, with what waits for the next start.
  const Settings<S>& configured() const { return configured_; }
  /// What is in force with the staged changes: what a reader of parameters expects to see.
  const Settings<S>& staged() const { return staged_; }

  bool on_trial() const { return S(0) < trial_s_; }
  /// What is left of a trial; nothing without one.
  S trial_left_s() const { return trial_s_; }
  bool waits_for_reset() const {
    return !same_settings(configured_, with_boot_values(configured_));
  }

  /// Remembers a value. A refused one leaves everything as it was.
  StageResult stage(Key key, Value value, bool enabled) {
    const std::size_t i = find_parameter(key);
    if (i == no_parameter) {
      return StageResult::unknown_parameter;
    }
    const ParameterRow<S>& row = parameter_rows<S>[i];
    switch (fit(row, value)) {
      case Fit::not_finite:
        return StageResult::not_finite;
      case Fit::below:
        return StageResult::below;
      case Fit::above:
        return StageResult::above;
      case Fit::inside:
        break;
    }
    if (enabled && row.change == Change::without_current && row.get(active_) != value) {
      return StageResult::while_enabled;
    }
    row.set(staged_, value);
    return StageResult::ok;
  }

  /// Forgets what is staged.
  void discard() { staged_ = on_trial() ? with_reset_values(active_) : configured_; }

  /// Puts the staged set in force: all of it or nothing.
  Applied apply(bool enabled) {
    if (on_trial()) {
      return {ApplyProblem::on_trial};
    }
    const Applied allowed = may_apply(enabled);
    if (allowed.ok()) {
      configured_ = staged_;
      put_in_force(staged_);
    }
    return allowed;
  }

  /// The same for so long. While a trial runs, another one takes its place; both go back to what
  /// was there before the first.
  Applied try_for(S duration_s) {
    if (!(S(0.1) <= duration_s && duration_s <= S(3600))) {
      return {ApplyProblem::duration};
    }
    for (std::size_t i = 0; i < parameter_count; ++i) {
      const ParameterRow<S>& row = parameter_rows<S>[i];
      if (row.change != Change::live && row.get(staged_) != row.get(configured_)) {
        return {ApplyProblem::only_live, i};
      }
    }
    const Applied allowed = may_apply(false);
    if (allowed.ok()) {
      put_in_force(staged_);
      trial_s_ = duration_s;
    }
    return allowed;
  }

  /// Keeps what is on trial.
  Applied commit() {
    if (!on_trial()) {
      return {ApplyProblem::no_trial};
    }
    configured_ = with_reset_values(active_);
    trial_s_ = S(0);
    return {};
  }

  /// Ends a trial and forgets what is staged.
  void revert() {
    trial_s_ = S(0);
    staged_ = configured_;
    put_in_force(configured_);
  }

  /// Others have put these in force, which have passed check(): trial and staged changes are gone.
  void replace(const Settings<S>& settings) {
    active_ = settings;
    configured_ = settings;
    revert();
  }

  /// Once per step. Whether a trial has just run out: active() has changed.
  bool tick(S dt_s) {
    if (!on_trial()) {
      return false;
    }
    trial_s_ -= dt_s;
    if (on_trial()) {
      return false;
    }
    revert();
    return true;
  }

 private:
  void put_in_force(const Settings<S>& settings) {
    active_ = with_boot_values(settings);
    ++changes_;
  }
  Applied may_apply(bool enabled) const {
    for (std::size_t i = 0; enabled && i < parameter_count; ++i) {
      const ParameterRow<S>& row = parameter_rows<S>[i];
      if (row.change == Change::without_current && row.get(staged_) != row.get(active_)) {
        return {ApplyProblem::while_enabled, i};
      }
    }
    // Until the next start new values meet old ones of what waits for it: both sets must do.
    for (const Settings<S>& set : {staged_, with_boot_values(staged_)}) {
      const Finding finding = check(set);
      if (!finding.ok()) {
        return {ApplyProblem::refused, finding.parameter, finding};
      }
    }
    return {};
  }

  static Settings<S> with_after_reset(Settings<S> settings, const Settings<S>& from) {
    for (const ParameterRow<S>& row : parameter_rows<S>) {
      if (row.change == Change::after_reset) {
        row.set(settings, row.get(from));
      }
    }
    return settings;
  }
  Settings<S> with_boot_values(const Settings<S>& settings) const {
    return with_after_reset(settings, active_);
  }
  Settings<S> with_reset_values(const Settings<S>& settings) const {
    return with_after_reset(settings, configured_);
  }

  Settings<S> active_, configured_, staged_;
  S trial_s_ = S(0);  ///< what is left of it
  std::uint32_t changes_ = 0;
};

}  // namespace smaservo
