#include "firmware/daemon/service/reloader.hpp"

#include <exception>
#include <fmt/format.h>

#include "firmware/daemon/bus/kept_settings.hpp"
#include "firmware/text/settings_file.hpp"
#include "firmware/text/settings_text.hpp"

namespace smaservo::daemon {
namespace {

/// The settings with all values of the file that may change now; `said` gets those that may not.
Settings<double> merged(const Settings<double>& before, const Reload& reload, bool heated,
                        std::vector<std::string>& said) {
  Settings<double> to = before;
  for (const Parameter<double>& row : parameters<double>) {
    const bool may =
        row.change == Change::live || (row.change == Change::without_current && !heated);
    if (may) {
      row.set(to, row.get(reload.settings));
    } else if (row.get(reload.settings) != row.get(before)) {
      said.push_back(fmt::format("{}: {} is not changed: {}", reload.file, row.path.text(),
                                 row.change == Change::after_reset
                                     ? "it changes only at a start"
                                     : "it does not change while the wire is heated"));
    }
  }
  return to;
}

}  // namespace

Reloaded reloaded(const Settings<double>& before, const Reload& reload, bool heated) {
  Reloaded result{};
  result.settings = merged(before, reload, heated, result.said);
  const std::string problem =
      !check(result.settings).ok()
          ? "the settings contradict each other or those that cannot change now"
      : reload.problem ? reload.problem(result.settings)
                       : "";
  if (!problem.empty()) {
    result.said.push_back(fmt::format("{}: nothing is changed: {}", reload.file, problem));
    return result;
  }
  const std::string changes = text::changes_text(before, result.settings);
  result.taken = !changes.empty();
  result.said.push_back(fmt::format(
      "{}: {}", reload.file,
      result.taken ? "in force now: " + changes : "nothing that may change now differs"));
  return result;
}

void Reloader::reload() const {
  ReloadBox& box = desk_.reloads();
  if (setup_.file.empty()) {
    box.say({"SIGHUP: nothing is changed: no settings file was given (--device)"});
    return;
  }
  if (has_settings(setup_.folder)) {
    box.say(
        {fmt::format("SIGHUP: nothing is changed: {} has stored settings, which go before {}; "
                     "restore the defaults (1011h) to return to the file",
                     setup_.folder, setup_.file)});
    return;
  }
  try {
    Reload read{setup_.file, text::load_settings_file(setup_.file), setup_.problem};
    if (box.bus_serves()) {
      box.put(std::move(read));
    } else {
      apply(read);
    }
  } catch (const std::exception& error) {
    box.say({fmt::format("nothing is changed: {}", error.what())});
  }
}

/// Without a bus this thread is the one that changes the settings.
void Reloader::apply(const Reload& reload) const {
  desk_.tidy();
  const std::uint32_t from = desk_.changes();
  Reloaded result = reloaded(desk_.settings(), reload, heated_.load());
  if (result.taken && !desk_.change(result.settings, from)) {
    result.said = {fmt::format(
        "{}: nothing is changed: too many changes at once; send SIGHUP again", reload.file)};
  }
  desk_.reloads().say(result.said);
}

}  // namespace smaservo::daemon
