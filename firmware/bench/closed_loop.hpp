#pragma once
// The firmware's own step on simulated wires.

#include <memory>
#include <optional>

#include "firmware/bench/scenario/closed_loop_scenario.hpp"
#include "firmware/cycle.hpp"
#include "firmware/device/device.hpp"
#include "hal/sim/pair.hpp"

namespace smaservo::bench {

/// One step of the device, and the truth at the time of its sample.
struct SimulatedCycle : Cycle {
  hal::SimTruth truth;
};

/// The second wire of a pair, at the same instant.
struct OtherWire {
  double strain, current_A, hottest_K;
};

/// Cost of a step: the device's, the plant's, and 0.1 us. Nothing is allocated after the start. A
/// pair takes some ten steps of each plant.
class ClosedLoop {
 public:
  explicit ClosedLoop(const ClosedLoopScenario& scenario);
  ~ClosedLoop() = default;
  // Not copied, since its members refer to each other.
  ClosedLoop(const ClosedLoop&) = delete;
  ClosedLoop& operator=(const ClosedLoop&) = delete;

  /// Runs one period; false when the scenario's time is over.
  bool step();
  const SimulatedCycle& cycle() const { return cycle_; }
  std::optional<OtherWire> other() const;

 private:
  /// A wire with the device that drives it.
  struct ControlledWire {
    ControlledWire(const Prepared<double>& prepared, const PlantSetup& plant,
                   const hal::SimSetup& setup)
        : device(Device<double>::start()), prepared_(prepared), board(make_plant(plant), setup) {}
    void step(hal::ReadStatus status, const hal::Frame& frame, const Heard<double>& heard,
              double dt_s, std::int64_t period_ns, DeviceStep<double>& now);

    Device<double>::State device;
    const Prepared<double>& prepared_;
    hal::SimBoard board;
  };

  Command<double> opposite(const Command<double>& command) const;

  Prepared<double> prepared_;
  std::int64_t period_ns_, end_ns_;
  double nominal_s_;
  ControlledWire first_;
  std::unique_ptr<ControlledWire> second_;
  bool second_drives_ = false;
  std::optional<hal::SimPair> pair_;
  double rest_strains_ = 0;  ///< of both wires together
  CommandProgram program_;
  SimEvents events_;
  bool began_ = false;
  std::int64_t time_ns_ = 0;
  SimulatedCycle cycle_{};
};

}  // namespace smaservo::bench
