#pragma once
// Files of small networks.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace smaservo::test {

/// A network of one unit that can be computed by hand: both gates are half open, the candidate is
/// tanh(resistance + 2 * (reset * state)), and the state is the strain as a share of 4 %.
inline nlohmann::ordered_json small_network() {
  const std::vector<double> none{0.0, 0.0, 0.0};
  const std::vector<std::vector<double>> no_input{none}, no_state{{0.0}};
  using Json = nlohmann::ordered_json;
  const auto scales = [](const char* name, const char* unit, double scale) {
    return Json{{"name", name}, {"unit", unit}, {"mean", 0}, {"scale", scale}};
  };
  return {{"format", "smaservo-gru"},
          {"version", 1},
          {"hidden", 1},
          {"step_s", 0.01},
          {"nominal_stroke", 0.04},
          {"seed", 1},
          {"epochs", 300},
          {"runs", Json::array({{{"name", "a.csv"}, {"rows", 200}, {"checksum", "00"}}})},
          {"inputs", Json::array({scales("resistance", "of the first", 1), scales("power", "W", 1),
                                  scales("stress", "MPa", 1)})},
          {"output", scales("strain", "% of the nominal stroke", 100)},
          {"weights",
           {{"reset_input", no_input},
            {"reset_state", no_state},
            {"reset_bias", {0.0}},
            {"update_input", no_input},
            {"update_state", no_state},
            {"update_bias", {0.0}},
            {"candidate_input", Json::array({{1.0, 0.0, 0.0}})},
            {"candidate_state", Json::array({Json::array({2.0})})},
            {"candidate_bias", {0.0}},
            {"output", {1.0}},
            {"output_bias", 0.0}}}};
}

}  // namespace smaservo::test
