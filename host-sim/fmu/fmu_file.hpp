#pragma once
// Makes the description of an FMU of a wire or a servo, and writes the FMU.

#include <optional>
#include <string>
#include <vector>

#include "host-sim/fmu/description.hpp"
#include "model/files/toml/fields.hpp"

namespace smaservo::fmu {

struct ExportOptions {
  Kind kind = Kind::wire;
  Version version = Version::fmi3;
  std::string wire;      ///< preset or file; empty: that of the settings
  std::string settings;  ///< file; empty: the default settings for the wire
  std::vector<files::Override> overrides;
  std::optional<double> load_N;  ///< at the beginning; none: 100 MPa
  std::string out;
};

/// Throws UserError.
Description describe(const ExportOptions& options);

/// What was written.
struct Written {
  std::size_t bytes;
  std::vector<std::string> platforms;  ///< for which a shared library is inside, as FMI names them
  std::size_t parameters, inputs, outputs;
};

/// Writes the FMU. Throws UserError.
Written write_fmu(const Description& description, Version version, const std::string& out);

}  // namespace smaservo::fmu
