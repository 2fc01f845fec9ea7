#pragma once
// All parameters of a servo as a settings file, and back.

#include "host-sim/can/remote.hpp"

namespace smaservo::can {

/// Reads all parameters of the node. Throws UserError when it has no wire yet.
Settings<double> read_settings(Remote& remote);

/// The settings of a file for this node; serial number and node-id stay the node's own.
Settings<double> file_settings(const std::string& path, const Settings<double>& of_node);

/// The same from a text, which messages call `origin`. Throws UserError where it names a file: the
/// text comes from somebody who may not read those of this machine.
Settings<double> text_settings(const std::string& toml, const std::string& origin,
                               const Settings<double>& of_node);

struct Difference {
  const Parameter<double>* row;
  Value here, there;  ///< in the file, in the node
};
std::vector<Difference> differences(const Settings<double>& file, const Settings<double>& node);

/// One line for each: path, the file's value, the node's value.
std::string differences_text(const std::vector<Difference>& differences);

/// Writes the file's values as one set. When it throws UserError, nothing has changed.
void restore(Remote& remote, const std::vector<Difference>& differences);

}  // namespace smaservo::can
