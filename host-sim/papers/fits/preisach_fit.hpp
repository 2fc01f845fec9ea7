#pragma once
// A wire's Preisach model from first-order reversal curves, as in paper 003, section III.

#include <string>
#include <vector>

#include "host-sim/identify/runs/run.hpp"
#include "model/papers/preisach.hpp"

namespace smaservo::fits {

/// The strain at one stress of a Preisach model; linear between two stresses and constant beyond.
struct PreisachStrain {
  double austenite;  ///< elongation of austenite
  double stroke;  ///< elongation of martensite less that of austenite; F in 003 is this times the
                  ///< model's F
};

struct PreisachWire {
  papers::Preisach<double>::Params kinetics;
  std::vector<PreisachStrain> strains;  ///< one for each stress of the kinetics

  double strain(double martensite, double stress_Pa) const;
  /// F as in 003, as a strain and over the true temperatures. hot_K >= cold_K.
  double increment(double hot_K, double cold_K, double stress_Pa) const;
};

/// The effect of stress on the input: see PreisachParams::shift_K_Pa.
enum class StressShift : unsigned char {
  none,   ///< as in 003
  fitted  ///< fitted to the temperatures at which the strain is half way
};

struct PreisachFit {
  PreisachWire wire;
  std::vector<std::vector<double>> strain;  ///< the model's strain in each run's rows
  double rms;                               ///< error over all rows, as a share of the stroke
  std::string remark;                       ///< what the runs do not determine; empty: nothing
};

/// F is fitted to the strains directly, without differentiation: the strain is linear in the
/// weights of the grid's cells, whose sums are F, and the weights are non-negative (physically μ >=
/// 0) with the least squares. A slight pull towards even weights decides what the rows leave open.
/// Runs whose stresses are within 3 MPa of each other share a slice. At most 4000 rows of a run are
/// used. Reversals of the temperature below 0.5 K are ignored. Cost: a second for five slices.
/// Throws UserError for no run, one that is not in a bath or has no strain, a stress that is not
/// constant, more than 8 stresses, a run that begins neither hot nor cold, and for a stress with
/// fewer than five reversal curves.
PreisachFit fit_preisach(const std::vector<identify::Run>& runs, StressShift shift);

/// Like fit_preisach(), from any histories under any load, at the given stresses (rising, up to 8):
/// a row between two of them counts for both, and the weights of neighbouring stresses are tied
/// together. The temperature may come from a heat balance, whose errors are then in the model. Runs
/// must begin hot, or cooled down from hot. Throws UserError for no run, one without temperature,
/// stress or strain, and for stresses that do not rise or are too many.
PreisachFit fit_preisach_histories(const std::vector<identify::Run>& runs,
                                   const std::vector<double>& stresses_Pa, double shift_K_Pa);

}  // namespace smaservo::fits
