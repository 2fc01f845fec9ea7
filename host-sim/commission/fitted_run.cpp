#include "host-sim/commission/fitted_run.hpp"

#include <chrono>
#include <fmt/format.h>
#include <utility>

#include "model/files/error.hpp"

namespace smaservo::commission {

identify::Run heated_run(const std::string& path, identify::RunOptions options) {
  options.strain_optional = true;
  identify::Run run = identify::read_run(path, options);
  if (run.kind != identify::RunKind::joule) {
    throw files::UserError(
        fmt::format("{}: is a {} run; commissioning needs one that heats the wire by its current, "
                    "with time, current, voltage and load",
                    run.name, identify::name_of(run.kind)));
  }
  return run;
}

Commissioning fitted_run(files::WireDescription from, const identify::Run& recorded,
                         const std::vector<Anchor>& anchors, const CommissionOptions& options,
                         const std::string& run, const std::string& out) {
  const auto start = std::chrono::steady_clock::now();
  Commissioning all;
  all.from = std::move(from);
  all.run = run;
  all.out = out;
  all.zero = options.zero;
  all.found = commission(all.from.wire, recorded, anchors, options);
  all.elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return all;
}

}  // namespace smaservo::commission
