#pragma once
// Changes of parameters: staged one by one, checked and applied as a set. A trial is in force for a
// limited time and is reverted at its end unless it is committed.
//
//   stage, stage, apply                  in force, and will be stored
//   stage, stage, try_for(30 s), commit  in force at once, stored when committed
//   stage, try_for(30 s), no commit      after 30 s as before
//
// Another object owns the settings in force (settings_owner.hpp): OwnSettings in a program with one
// thread, ParameterDesk in the daemon.
//
// apply() and try_for() are not for the loop: they cost some ten microseconds on a PC. tick() is
// for the loop.

#include "firmware/parameters/parameter_check.hpp"
#include "firmware/parameters/settings_owner.hpp"

namespace smaservo {

enum class StageResult : std::uint8_t {
  ok,
  unknown_parameter,
  not_finite,
  below,          ///< below its least value
  above,          ///< above its greatest value
  while_enabled,  ///< may change only without current
};

enum class ApplyProblem : std::uint8_t {
  none,
  refused,        ///< the set is out of range or contradictory: see the finding
  while_enabled,  ///< the device was enabled meanwhile: a staged parameter may not change now
  only_live,      ///< a trial takes only parameters that may change at any time
  on_trial,       ///< a trial is running: commit() or revert() comes first
  no_trial,       ///< there is nothing to commit
  duration,       ///< the duration of a trial must be 0.1 s to an hour
};

struct Applied {
  ApplyProblem problem = ApplyProblem::none;
  std::size_t parameter = no_parameter;  ///< the first parameter that may not change
  Finding finding{};

  constexpr bool ok() const { return problem == ApplyProblem::none; }
};

template <class S>
class Staging {
 public:
  /// The owner must outlive the Staging; its settings must have passed check().
  explicit Staging(SettingsOwner<S>& owner)
      : owner_(owner), configured_(owner.settings()), staged_(owner.settings()) {}

  /// The settings in force. Staging puts others in force only in apply(), try_for(), revert(),
  /// tick(), replace() and restart(), and always as a whole.
  const Settings<S>& active() const { return owner_.settings(); }
  /// Whether the owner can take a change.
  bool has_room() const { return owner_.has_room(); }
  /// The settings to store: without those on trial, but with those that wait for the next start.
  const Settings<S>& configured() const { return configured_; }
  /// The settings in force with the staged changes, as a reader of parameters expects to see them.
  const Settings<S>& staged() const { return staged_; }

  bool on_trial() const { return S(0) < trial_s_; }
  /// The time left of a trial; 0 if there is none.
  S trial_left_s() const { return trial_s_; }
  bool waits_for_reset() const {
    return !same_settings(configured_, with_boot_values(configured_));
  }

  /// Stages a value. A refused value changes nothing.
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
    if (enabled && row.change == Change::without_current && row.get(active()) != value) {
      return StageResult::while_enabled;
    }
    row.set(staged_, value);
    return StageResult::ok;
  }

  /// Drops the staged changes.
  void discard() { staged_ = on_trial() ? with_reset_values(active()) : configured_; }

  /// Puts the staged set in force, completely or not at all.
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

  /// Puts the staged set in force for `duration_s`. Another trial replaces a running one; at its
  /// end the settings from before the first trial are in force again.
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

  /// Makes the settings on trial permanent.
  Applied commit() {
    if (!on_trial()) {
      return {ApplyProblem::no_trial};
    }
    configured_ = with_reset_values(active());
    trial_s_ = S(0);
    return {};
  }

  /// Ends a trial and drops the staged changes.
  void revert() {
    trial_s_ = S(0);
    staged_ = configured_;
    put_in_force(configured_);
  }

  /// Takes over settings that were put in force by others and have passed check(). A trial and
  /// staged changes are dropped; values that wait for the next start keep waiting, unless they
  /// contradict these settings.
  void replace(const Settings<S>& settings) {
    const Settings<S> waiting = with_after_reset(settings, configured_);
    configured_ = check(waiting).ok() ? waiting : settings;
    staged_ = configured_;
    trial_s_ = S(0);
    owner_.put(settings);
  }

  /// As after switching on with these settings, which must have passed check(): nothing is staged,
  /// on trial or waiting.
  void restart(const Settings<S>& settings) {
    configured_ = staged_ = settings;
    trial_s_ = S(0);
    owner_.put(settings);
  }

  /// To be called once per step. True if a trial has just ended, so that active() has changed.
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
  void put_in_force(const Settings<S>& settings) { owner_.put(with_boot_values(settings)); }
  Applied may_apply(bool enabled) const {
    for (std::size_t i = 0; enabled && i < parameter_count; ++i) {
      const ParameterRow<S>& row = parameter_rows<S>[i];
      if (row.change == Change::without_current && row.get(staged_) != row.get(active())) {
        return {ApplyProblem::while_enabled, i};
      }
    }
    // Parameters that wait for the next start keep their old values until then, together with the
    // new values of the others: the settings must pass in both cases.
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
    return with_after_reset(settings, active());
  }
  Settings<S> with_reset_values(const Settings<S>& settings) const {
    return with_after_reset(settings, configured_);
  }

  SettingsOwner<S>& owner_;
  Settings<S> configured_, staged_;
  S trial_s_ = S(0);  ///< time left of the trial
};

}  // namespace smaservo
