#pragma once
// A wire's Preisach model from first-order reversal curves, after paper 003, section III.

#include <string>
#include <vector>

#include "host-sim/identify/runs/run.hpp"
#include "model/papers/preisach.hpp"

namespace smaservo::fits {

/// Strain at one stress of a Preisach model, linear between two and constant beyond.
struct PreisachStrain {
  double austenite;  ///< elongation of austenite
  double stroke;     ///< by how much martensite is longer; 003's F is this times the model's
};

struct PreisachWire {
  papers::Preisach<double>::Params kinetics;
  std::vector<PreisachStrain> strains;  ///< one for each stress of the kinetics

  double strain(double martensite, double stress_Pa) const;
  /// F as 003 has it, in strain and over the true temperatures. hot_K >= cold_K.
  double increment(double hot_K, double cold_K, double stress_Pa) const;
};

/// What stress does to the input: see PreisachParams::shift_K_Pa.
enum class StressShift : unsigned char {
  none,   ///< 003
  fitted  ///< to the temperatures at which the strain is half way
};

struct PreisachFit {
  PreisachWire wire;
  std::vector<std::vector<double>> strain;  ///< the model's strain in each run's rows
  double rms;          ///< of the error over all rows, as a share of the stroke
  std::string remark;  ///< what the runs leave open; empty: nothing
};

/// F is fitted to the strains themselves, without differentiation: the strain is linear in the
/// weights of the grid's cells, whose sums F is, and they are the non-negative ones (physically
/// μ >= 0) with the least squares. A slight pull towards even weights decides what the rows leave
/// open. Runs whose stresses are within 3 MPa of each other share a slice. Rows: at most 4000 of a
/// run count. A reversal of the temperature counts from 0.5 K on. Cost: a second for five slices.
/// Throws UserError for no run, one that is not in a bath or has no strain, a stress that is not
/// constant, more than 8 stresses, a run that begins neither hot nor cold, and for a stress with
/// fewer than five reversal curves.
PreisachFit fit_preisach(const std::vector<identify::Run>& runs, StressShift shift);

/// The same from any histories under any load, at these stresses (rising, up to 8): a row between
/// two of them counts for both, and the weights of neighbours are held together. The temperature
/// may come from a heat balance, whose errors are then in the model. Runs begin hot, or cooled down
/// from hot. Throws UserError for no run, one without temperature, stress or strain, and for
/// stresses that do not rise or are too many.
PreisachFit fit_preisach_histories(const std::vector<identify::Run>& runs,
                                   const std::vector<double>& stresses_Pa, double shift_K_Pa);

}  // namespace smaservo::fits
