#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>

#include "firmware/safety/faults/table.hpp"
#include "firmware/text/fault_reference.hpp"
#include "host-sim/describe/describe_command.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"

namespace smaservo::describe {
namespace {

void list_faults() {
  for (const FaultRow& row : fault_rows) {
    files::print(fmt::format("{:04X}h  {:<2}  {:<20}{}\n", row.code, class_name(row.severity),
                             row.name, row.text));
  }
}

void explain(const std::string& name) {
  const Fault fault = text::find_fault(name);
  if (fault == Fault::none) {
    const std::vector<std::string> close = text::similar_faults(name);
    throw files::UserError(
        close.empty()
            ? fmt::format("{}: no such fault; `host-sim explain` lists them", name)
            : fmt::format("{}: no such fault; did you mean {}?", name, fmt::join(close, ", ")));
  }
  files::print(text::explain_fault(fault));
}

}  // namespace

void add_explain_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "explain", "Says what a fault of the device means, what causes it, what to check.");
  auto name = std::make_shared<std::string>();
  command->add_option("FAULT", *name, "name or code, such as 2310h; default: lists all faults");
  command->callback([name] { name->empty() ? list_faults() : explain(*name); });
}

}  // namespace smaservo::describe
