#pragma once
// A recurrent network of gated units (GRU; Cho et al., 2014) that estimates the strain of a wire.
// train.py in this folder trains it and writes its file.

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace smaservo::gru {

/// What the network is told at each step.
struct Inputs {
  double resistance;  ///< as a share of the run's first one
  double power_W;     ///< mean since the last step
  double stress_MPa;  ///< filtered
};
inline constexpr int input_count = 3;

/// A run that the network was trained on.
struct TrainingRun {
  std::string name;
  std::uint64_t rows;
  std::string checksum;  ///< by checksum_of()
};

/// The weights of all units for one of their three parts.
struct Gate {
  Eigen::MatrixXd input, state;  ///< a row for each unit
  Eigen::VectorXd bias;
};

struct Network {
  double step_s;
  double nominal_stroke;  ///< of which the network's output is a share
  Eigen::Vector3d input_mean, input_scale;
  double strain_mean_percent, strain_scale_percent;  ///< of the nominal stroke
  Gate reset, update, candidate;
  Eigen::VectorXd output;
  double output_bias;
  std::vector<TrainingRun> runs;

  int hidden() const { return static_cast<int>(output.size()); }
  /// Number of weights.
  int parameters() const;
};

/// A network as it runs.
class Cell {
 public:
  explicit Cell(const Network& network);
  /// The strain after a step with these inputs.
  double next(const Inputs& inputs);

 private:
  const Network& network_;
  Eigen::VectorXd state_;
};

/// Names the content of a run: a hash of its strain, to the last bit.
std::string checksum_of(const std::vector<double>& strain);

/// Reads a network's file. Throws ConfigError, which names the file, the key, its value and what is
/// allowed, for anything but what train.py writes.
Network load_network(const std::string& path);
/// The same of the file's text; `path` is for messages.
Network parse_network(const std::string& path, std::string_view text);

}  // namespace smaservo::gru
