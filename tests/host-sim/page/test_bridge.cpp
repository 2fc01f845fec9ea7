// test_bridge [--rate HZ] [--page FILE] and the options of host-sim page but --can.

#include <algorithm>
#include <fstream>
#include <iterator>

#include "host-sim/page/bridge.hpp"
#include "model/files/error.hpp"
#include "model/files/message.hpp"
#include "tests/host-sim/page/test_source.hpp"

int main(int argc, char** argv) {
  using namespace smaservo;
  page::BridgeSettings settings;
  settings.version = "test";
  double rate_Hz = 1000;
  std::string page;
  const std::vector<std::string> words(argv + 1, argv + argc);
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& option = words[i];
    const auto value = [&] { return words.at(++i); };
    if (option == "--read-only") {
      settings.read_only = true;
    }
    if (option == "--listen") {
      settings.listen = value();
    }
    if (option == "--token-file") {
      settings.token_file = value();
    }
    if (option == "--certificate") {
      settings.certificate = value();
    }
    if (option == "--key") {
      settings.key = value();
    }
    if (option == "--allow-origin") {
      settings.origins.push_back(value());
    }
    if (option == "--clients") {
      settings.clients = static_cast<unsigned>(std::stoul(value()));
    }
    if (option == "--rate") {
      rate_Hz = std::stod(value());
    }
    if (option == "--page") {
      std::ifstream in(value(), std::ios::binary);
      page.assign(std::istreambuf_iterator<char>(in), {});
      settings.page = page;
    }
  }
  try {
    page::run_bridge(settings, [&] { return std::make_unique<page::TestSource>(rate_Hz); });
  } catch (const files::UserError& error) {
    files::complain("test_bridge", error.what());
    return 1;
  }
  return 0;
}
