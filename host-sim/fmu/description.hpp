#pragma once
// An FMU as data, and its model description as XML, of FMI 2.0 and 3.0.

#include <string>
#include <utility>
#include <vector>

#include "host-sim/fmu/unit/variables.hpp"

namespace smaservo::fmu {

enum class Kind : unsigned char { wire, servo };
enum class Version : unsigned char { fmi2, fmi3 };

/// All that is particular to one FMU.
struct Description {
  Kind kind;
  std::string name;  ///< of the wire or of the settings
  std::vector<unit::Variable> variables;
  std::vector<double> start;  ///< of each variable; those of outputs have no meaning
  /// Numbers of the file of values that are no variables.
  std::vector<std::pair<std::string, double>> constants;
  double step_s;                     ///< the communication step that is proposed
  std::vector<std::string> sources;  ///< to be compiled, below the folder sources
};

/// "smaservo_wire" or "smaservo_servo": the name of the shared library.
std::string identifier(Kind kind);

/// A number over the whole description, as {XXXXXXXX-XXXX-...}: GUID of FMI 2, instantiation token
/// of FMI 3.
std::string token_of(const Description& description, Version version);

/// modelDescription.xml.
std::string model_description(const Description& description, Version version);
/// sources/buildDescription.xml of FMI 3.
std::string build_description(const Description& description);
/// resources/values.txt, which unit/constants.hpp describes.
std::string values_file(const Description& description, Version version);
/// documentation/index.html.
std::string documentation(const Description& description);

}  // namespace smaservo::fmu
