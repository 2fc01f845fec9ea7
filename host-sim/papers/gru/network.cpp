#include "host-sim/papers/gru/network.hpp"

#include <bit>
#include <cmath>

#include "host-sim/hash.hpp"

namespace smaservo::gru {
namespace {

Eigen::VectorXd sigmoid(const Eigen::VectorXd& x) {
  return 0.5 + 0.5 * (0.5 * x.array()).tanh();
}

Eigen::VectorXd sum(const Gate& gate, const Eigen::Vector3d& inputs, const Eigen::VectorXd& state) {
  return gate.input * inputs + gate.state * state + gate.bias;
}

}  // namespace

int Network::parameters() const {
  // Three gates, each with inputs, states and a bias; the output, and its bias.
  return 3 * hidden() * (input_count + hidden() + 1) + hidden() + 1;
}

Cell::Cell(const Network& network)
    : network_(network), state_(Eigen::VectorXd::Zero(network.hidden())) {}

double Cell::next(const Inputs& inputs) {
  const Network& n = network_;
  const Eigen::Vector3d scaled =
      (Eigen::Vector3d(inputs.resistance, inputs.power_W, inputs.stress_MPa) - n.input_mean)
          .cwiseQuotient(n.input_scale);
  const Eigen::VectorXd reset = sigmoid(sum(n.reset, scaled, state_));
  const Eigen::VectorXd update = sigmoid(sum(n.update, scaled, state_));
  const Eigen::VectorXd candidate =
      sum(n.candidate, scaled, reset.cwiseProduct(state_)).array().tanh();
  state_ = candidate + update.cwiseProduct(state_ - candidate);
  const double percent =
      n.strain_mean_percent + n.strain_scale_percent * (n.output.dot(state_) + n.output_bias);
  return percent / 100 * n.nominal_stroke;
}

std::string checksum_of(const std::vector<double>& strain) {
  constexpr int bytes = 8;
  Hash hash;
  for (const double value : strain) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    std::string text;
    for (int i = 0; i < bytes; ++i) {
      text += static_cast<char>(bits >> (8 * i) & 0xFFU);
    }
    hash.add(text);
  }
  return hash.hex();
}

}  // namespace smaservo::gru
