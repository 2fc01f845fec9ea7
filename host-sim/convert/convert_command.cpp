#include "host-sim/convert/convert_command.hpp"

#include <fmt/format.h>
#include <memory>

#include "host-sim/convert/convert.hpp"
#include "model/files/message.hpp"

namespace smaservo::convert {

void add_convert_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "convert",
      "Makes MCAP of a CSV trace or recording, and CSV of MCAP or of another program's table; "
      "repairs what was cut off.");
  auto a = std::make_shared<ConvertOptions>();
  auto plain = std::make_shared<bool>(false);
  command->add_option("TRACE", a->in, "table as text or MCAP file, - for standard input")
      ->required();
  command
      ->add_option("--out", a->out,
                   "MCAP file if the name ends in .mcap, else CSV; - is CSV on standard output")
      ->required();
  command->add_option("--topic", a->topic,
                      "channel of an MCAP file; default: /trace, or the only one with messages");
  command->add_option("--column", a->renames, column_help)->allow_extra_args(false);
  command->add_flag("--uncompressed", *plain, "make an MCAP file without compression");
  command->callback([a, plain] {
    refuse_to_overwrite(a->in, a->out);
    a->compressed = !*plain;
    const Converted result = convert(*a);
    std::string text = fmt::format("{}: {} rows, {} columns\n", files::printable(a->in),
                                   result.rows, result.columns);
    if (!result.cut_off.empty()) {
      text += fmt::format("  {}\n", files::printable(result.cut_off));
    }
    for (const std::string& remark : result.remarks) {
      text += fmt::format("  {}\n", files::printable(remark));
    }
    files::print(text, a->out == "-" ? stderr : stdout);
  });
}

}  // namespace smaservo::convert
