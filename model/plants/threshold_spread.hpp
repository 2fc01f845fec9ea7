#pragma once
// How the thresholds of one transformation are spread over the parts of a wire.

namespace smaservo {

struct ThresholdSpread {
  double median_K;          ///< median of the thresholds without stress
  double below_K, above_K;  ///< logistic scale on either side of the median, both > 0
  double per_Pa, per_Pa2;   ///< stress shifts all of them: per_Pa σ + per_Pa2 σ²
};

}  // namespace smaservo
