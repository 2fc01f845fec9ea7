#pragma once
// The electronics between a simulated wire and the frames of a board: the converter that drives the
// wire and the sensors that read it, with the faults of both.

#include <algorithm>
#include <array>
#include <cstdint>

#include "hal/board.hpp"
#include "hal/sim/simulated_bench.hpp"

namespace smaservo::hal {

/// The output stage.
struct Converter {
  bool voltage_drive = false;  ///< takes DriveCommand::voltage_V instead of current_A
  double max_A;                ///< current at which the converter saturates
  double slew_A_s;             ///< slew rate of the current; infinite: no limit
  double lead_ohm;             ///< resistance in series with the wire, outside of the sense leads
};

/// Readings that a sensor fault can affect.
enum class Reading : unsigned char { current, voltage, load, supply, ambient, driver };
inline constexpr std::size_t reading_count = 6;

enum class SensorFault : unsigned char {
  none,
  missing,  ///< reads NaN
  stuck,    ///< repeats the last reading bit for bit
  offset,   ///< adds `amount`, in the reading's unit
  noise,    ///< adds white noise with the standard deviation `amount`
  value,    ///< always reads `amount`: an open sense lead reads 0 or the supply rail
  gain,     ///< multiplies by `amount`
};

struct SpoiltSensor {
  SensorFault fault = SensorFault::none;
  double amount = 0;
};

/// The state of the wire's electrical path.
enum class Circuit : unsigned char {
  closed,
  broken,  ///< torn wire: no current, no load, the converter's voltage between the sense leads
  open,    ///< a current lead is open: no current, and no voltage between the sense leads
  shorted  ///< part of the wire is bridged
};

/// White noise whose bits do not depend on compiler or mathematics library: the sum of four uniform
/// numbers, so never beyond 3.5 standard deviations. It takes a twentieth of the time of
/// std::normal_distribution, which would take a fifth of the time of a closed loop.
class SensorNoise {
 public:
  explicit SensorNoise(std::uint64_t seed) : state_(seed) {}
  double operator()();
  double uniform();  ///< uniformly distributed, 0 <= x < 1

 private:
  std::uint64_t bits();

  std::uint64_t state_;
};

/// The faults in force, as events set them.
struct FrontEndFaults {
  Circuit circuit = Circuit::closed;
  double bridged_share = 0;  ///< share of the wire that is bridged when shorted
  std::array<SpoiltSensor, reading_count> sensors{};
  double lost_share = 0;  ///< share of the frames that are lost, 0..1
  bool emergency_stop = false;
  bool driver_fault = false;

  bool spoils() const {
    return std::ranges::any_of(
        sensors, [](const SpoiltSensor& sensor) { return sensor.fault != SensorFault::none; });
  }
};

/// Quantisation of a reading: step, its inverse, and full scale.
struct Quantiser {
  double step, per_step, full_scale;
};

class FrontEnd {
 public:
  FrontEnd(const Converter& converter, const Sensors& sensors, std::uint64_t seed);

  FrontEndFaults faults;

  /// The current into the wire during the next dt_s under this command (null: off).
  double advance(const DriveCommand* command, double supply_V, double wire_ohm, double dt_s);

  /// Writes the readings of these true values into `frame`; its time and sequence are left
  /// unchanged. False if the frame is lost.
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
  double driven_V_ = 0;  ///< voltage that the converter puts out
  Frame last_{};
};

}  // namespace smaservo::hal
