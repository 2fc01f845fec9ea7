#pragma once
// The token that clients on other machines need, in a file that only its owner can read.

#include <string>

namespace smaservo::page {

/// A new token: 256 random bits as hexadecimal digits.
std::string random_token();

/// The token in a file; if the file is missing, it is created with a random token. Refuses a file
/// that others may read, and a token that can be guessed. Throws UserError.
std::string token_of(const std::string& path);

/// The file of the token unless an option names another: below $STATE_DIRECTORY (for a service),
/// $XDG_STATE_HOME or $HOME/.local/state. Throws ConfigError if none is set.
std::string default_token_file();

}  // namespace smaservo::page
