#pragma once
// Converts between all parameters of a servo and a settings file.

#include "host-sim/can/remote.hpp"
#include "host-sim/units.hpp"

namespace smaservo::can {

/// Reads all parameters of the node. Throws UserError if its wire is not configured yet.
Settings<double> read_settings(Remote& remote);

/// The settings of a file for this node; serial number and node-id are those of the node.
Settings<double> file_settings(const std::string& path, const Settings<double>& of_node);

/// Like file_settings(), from a text, which messages name `origin`. Throws UserError if the text
/// refers to a file: its sender may not be allowed to read the files of this machine.
Settings<double> text_settings(const std::string& toml, const std::string& origin,
                               const Settings<double>& of_node);

struct Difference {
  const Parameter<double>* row;
  Value here, there;  ///< the value in the file, and that in the node
};
std::vector<Difference> differences(const Settings<double>& file, const Settings<double>& node);

/// One line for each difference: name with the unit, the file's value, the node's value.
std::string differences_text(const std::vector<Difference>& differences, Units units);

/// The bytes of a parameter's value on the bus.
Bytes bytes_of(const text::KnownObject& object, Value value);

/// Writes the file's values as one set. If it throws UserError, nothing has changed.
void restore(Remote& remote, const std::vector<Difference>& differences);

}  // namespace smaservo::can
