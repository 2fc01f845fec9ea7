#include "firmware/daemon/service/reloader.hpp"

#include <exception>
#include <fmt/format.h>

#include "firmware/text/settings_file.hpp"

namespace smaservo::daemon {

std::vector<std::string> Reloader::reload() const {
  if (file_.empty()) {
    return {"SIGHUP: nothing is changed: no settings file was given (--device)"};
  }
  std::vector<std::string> said;
  try {
    const Settings<double> to = changed(desk_.settings(), text::load_settings_file(file_), said);
    if (const std::string why = refused(to); !why.empty()) {
      said.push_back(fmt::format("{}: nothing is changed: {}", file_, why));
    }
  } catch (const std::exception& error) {
    said.push_back(fmt::format("nothing is changed: {}", error.what()));
  }
  return said;
}

Settings<double> Reloader::changed(const Settings<double>& before, const Settings<double>& from,
                                   std::vector<std::string>& said) const {
  Settings<double> to = before;
  for (const Parameter<double>& row : parameters<double>) {
    const bool may =
        row.change == Change::live || (row.change == Change::without_current && !heated_.load());
    if (may) {
      row.set(to, row.get(from));
    } else if (row.get(from) != row.get(before)) {
      said.push_back(fmt::format("{}: {} is not changed: {}", file_, row.path.text(),
                                 row.change == Change::after_reset
                                     ? "it changes only at a start"
                                     : "it does not change while the wire is heated"));
    }
  }
  return to;
}

std::string Reloader::refused(const Settings<double>& to) const {
  if (!check(to).ok()) {
    return "the settings contradict each other or those that can not change now";
  }
  std::string problem = problem_ ? problem_(to) : "";
  if (problem.empty() && !desk_.change(to)) {
    problem = "too many changes at once; send SIGHUP again";
  }
  return problem;
}

}  // namespace smaservo::daemon
