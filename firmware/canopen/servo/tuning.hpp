#pragma once
// The parameters of a device as objects: staged, tried and applied as a set (staging.hpp).

#include "firmware/canopen/node/objects.hpp"
#include "firmware/canopen/servo/parameter_access.hpp"
#include "firmware/parameters/staging.hpp"

namespace smaservo::canopen {

template <class S>
class Tuning final : public ParameterAccess {
 public:
  explicit Tuning(Staging<S>& staging) : staging_(staging) {}

  Abort find(Key key, Entry& entry) const override;
  std::uint32_t read(std::uint16_t row) const override {
    return parameter_rows<S>[row].get(staging_.staged()).bits;
  }
  Level level(std::uint16_t row) const override { return parameter_rows<S>[row].level; }
  Abort write(std::uint16_t row, std::uint32_t value, bool enabled) override;
  Abort tune(TuningCommand command, float trial_s, bool enabled) override;
  bool tick(float dt_s) override;

  bool has_room() const override { return staging_.has_room(); }
  TuningState state() const override {
    return staging_.on_trial() ? TuningState::on_trial
           : open_             ? TuningState::open
                               : TuningState::none;
  }
  float remaining_s() const override { return static_cast<float>(staging_.trial_left_s()); }
  Key refused() const override { return refused_; }
  Key refused_other() const override { return refused_other_; }
  Reach reach() const override {
    const Settings<S>& q = staging_.active();
    const S length_m = q.wire.geometry.length_m;
    return {static_cast<float>((q.axis.zero_strain - q.limits.max_strain) * length_m),
            static_cast<float>((q.axis.zero_strain - q.limits.min_strain) * length_m)};
  }
  bool has_load_cell() const override { return staging_.active().measurement.has_load_cell; }

  /// Takes over settings that were put in force other than over the bus; ends a transaction.
  void replace(const Settings<S>& settings) {
    staging_.replace(settings);
    open_ = false;
  }

 private:
  static Abort abort_of(StageResult result);
  Abort done(const Applied& applied);

  Staging<S>& staging_;
  Key refused_{}, refused_other_{};
  bool open_ = false;
};

template <class S>
Abort Tuning<S>::find(Key key, Entry& entry) const {
  constexpr std::array types{Type::real, Type::u32, Type::u8, Type::boolean};
  const auto key_of = [](const void* /*rows*/, std::size_t i) { return parameter_rows<S>[i].key; };
  std::size_t row = 0;
  const Abort found = find_row(parameter_count, key_of, nullptr, key, entry, row);
  if (found == Abort::none && row < parameter_count) {
    const Type type = types[static_cast<std::size_t>(parameter_rows<S>[row].type)];
    const auto access =
        static_cast<std::uint16_t>(readable | written_at(parameter_rows<S>[row].level));
    entry = {key, type, access, static_cast<std::uint16_t>(row), size_of(type)};
  }
  return found;
}

template <class S>
Abort Tuning<S>::abort_of(StageResult result) {
  switch (result) {
    case StageResult::ok:
      return Abort::none;
    case StageResult::unknown_parameter:
      return Abort::no_object;
    case StageResult::not_finite:
      return Abort::value;
    case StageResult::below:
      return Abort::too_low;
    case StageResult::above:
      return Abort::too_high;
    case StageResult::while_enabled:
      break;
  }
  return Abort::state;
}

/// The abort code of a result. If the set contradicts itself, the two parameters are kept for
/// refused() and refused_other().
template <class S>
Abort Tuning<S>::done(const Applied& applied) {
  const auto key = [](std::size_t row) {
    return row < parameter_count ? parameter_rows<S>[row].key : Key{};
  };
  refused_ = key(applied.parameter);
  refused_other_ = key(applied.finding.other);
  switch (applied.problem) {
    case ApplyProblem::none:
      return Abort::none;
    case ApplyProblem::refused:
      return Abort::incompatible;
    case ApplyProblem::duration:
      return Abort::value;
    default:
      return Abort::state;
  }
}

template <class S>
Abort Tuning<S>::write(std::uint16_t row, std::uint32_t value, bool enabled) {
  const Abort staged = abort_of(staging_.stage(parameter_rows<S>[row].key, {value}, enabled));
  if (staged != Abort::none || state() != TuningState::none) {
    return staged;
  }
  const Applied applied = staging_.apply(enabled);
  if (!applied.ok()) {
    staging_.discard();
  }
  return done(applied);
}

template <class S>
Abort Tuning<S>::tune(TuningCommand command, float trial_s, bool enabled) {
  switch (command) {
    case TuningCommand::none:
      return Abort::none;
    case TuningCommand::begin:
      if (state() != TuningState::none) {
        return Abort::state;
      }
      staging_.discard();
      open_ = true;
      return Abort::none;
    case TuningCommand::attempt:
    case TuningCommand::leave:
      return state() == TuningState::none ? Abort::state : done(staging_.try_for(S(trial_s)));
    case TuningCommand::commit: {
      if (state() == TuningState::none) {
        return Abort::state;
      }
      // Changes staged since the trial began belong to the transaction.
      const bool tried = staging_.on_trial();
      const Abort result = tried ? done(staging_.try_for(S(trial_s))) : Abort::none;
      const Abort kept = result != Abort::none ? result
                         : tried               ? done(staging_.commit())
                                               : done(staging_.apply(enabled));
      open_ = open_ && kept != Abort::none;
      return kept;
    }
    case TuningCommand::revert:
      if (state() != TuningState::none) {
        staging_.revert();
        open_ = false;
      }
      return Abort::none;
  }
  return Abort::value;
}

template <class S>
bool Tuning<S>::tick(float dt_s) {
  const bool ended = staging_.tick(S(dt_s));
  open_ = open_ && !ended;
  return ended;
}

}  // namespace smaservo::canopen
