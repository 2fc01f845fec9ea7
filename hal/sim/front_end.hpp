#pragma once
// What stands between a simulated wire and the frames of a board: the converter that drives it and
// the sensors that read it, with what can be wrong with both.

#include <algorithm>
#include <array>
#include <cstdint>

#include "hal/board.hpp"
#include "hal/sim/simulated_bench.hpp"

namespace smaservo::hal {

/// The output stage.
struct Converter {
  bool voltage_drive = false;  ///< takes DriveCommand::voltage_V, else current_A
  double max_A;                ///< saturates there
  double slew_A_s;             ///< of the current; infinite: none
  double lead_ohm;             ///< in series with the wire, outside of the sense leads
};

/// Readings that a sensor can spoil.
enum class Reading : unsigned char { current, voltage, load, supply, ambient, driver };
inline constexpr std::size_t reading_count = 6;

enum class SensorFault : unsigned char {
  none,
  missing,  ///< NaN
  stuck,    ///< the last reading, bit for bit
  offset,   ///< plus `amount`, in the reading's unit
  noise,    ///< plus white noise with the standard deviation `amount`
  value,    ///< says `amount` whatever there is: an open sense lead reads 0, or its rail
  gain,     ///< times `amount`
};

struct SpoiltSensor {
  SensorFault fault = SensorFault::none;
  double amount = 0;
};

/// The wire's electrical path.
enum class Circuit : unsigned char {
  closed,
  broken,  ///< the wire itself: no current, the sense leads see the converter's voltage, no load
  open,    ///< a current lead: no current, and nothing between the sense leads
  shorted  ///< part of the wire is bridged
};

/// White noise whose bits do not depend on compiler or mathematics library: four uniform numbers
/// together, so never beyond 3.5 standard deviations. A twentieth of the time of
/// std::normal_distribution, which would be a fifth of a closed loop's.
class SensorNoise {
 public:
  explicit SensorNoise(std::uint64_t seed) : state_(seed) {}
  double operator()();
  double uniform();  ///< 0 to 1, 1 excluded

 private:
  std::uint64_t bits();

  std::uint64_t state_;
};

/// What is wrong, as events set it.
struct FrontEndFaults {
  Circuit circuit = Circuit::closed;
  double bridged_share = 0;  ///< of the wire, where it is shorted
  std::array<SpoiltSensor, reading_count> sensors{};
  double lost_share = 0;  ///< of the frames that do not come, 0..1
  bool emergency_stop = false;
  bool driver_fault = false;

  bool spoils() const {
    return std::ranges::any_of(
        sensors, [](const SpoiltSensor& sensor) { return sensor.fault != SensorFault::none; });
  }
};

/// A converter's steps, and its full scale.
struct Quantiser {
  double step, per_step, full_scale;
};

class FrontEnd {
 public:
  FrontEnd(const Converter& converter, const Sensors& sensors, std::uint64_t seed);

  FrontEndFaults faults;

  /// The current that flows for the next dt_s with this command (null: off) into this wire.
  double advance(const DriveCommand* command, double supply_V, double wire_ohm, double dt_s);

  /// Whether a frame comes, and then its readings of these truths; time and sequence stay.
  struct Truth {
    double wire_ohm, load_N, supply_V, ambient_K, driver_K;
  };
  bool read(const Truth& truth, Frame& frame);

  double current_A() const { return current_A_; }

 private:
  double between_sense_leads_V(double wire_ohm) const;
  void spoil(Frame& frame);

  Converter converter_;
  Sensors sensors_;
  Quantiser current_, voltage_, load_;
  SensorNoise noise_, fault_noise_;
  double current_A_ = 0;
  double driven_V_ = 0;  ///< what the converter puts out
  Frame last_{};
};

}  // namespace smaservo::hal
