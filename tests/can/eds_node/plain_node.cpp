#include "tests/can/eds_node/plain_node.hpp"

#include <chrono>
#include <csignal>
#include <fmt/format.h>
#include <poll.h>

#include "hal/board.hpp"
#include "hal/linux/can/open_can.hpp"
#include "model/files/input_file.hpp"

namespace smaservo {
namespace {

using canopen::Abort;
using canopen::Entry;

constexpr std::size_t longest_value = 65536;

std::string_view text_at(const Eds& eds, std::uint16_t index) {
  for (const EdsObject& object : eds.objects) {
    if (object.key == Key{index, 0}) {
      return {reinterpret_cast<const char*>(object.standard.data()),  // NOLINT(*-reinterpret-cast)
              object.standard.size()};
    }
  }
  return {};
}

std::uint32_t number_at(const Eds& eds, Key key, std::uint32_t missing) {
  for (const EdsObject& object : eds.objects) {
    if (object.key == key && canopen::take_number(object.standard) != 0) {
      return static_cast<std::uint32_t>(canopen::take_number(object.standard));
    }
  }
  return missing;
}

bool is_communication(Key key) {
  return 0x1000 <= key.index && key.index <= 0x1FFF;
}

}  // namespace

canopen::NodeConfig PlainNode::config_of(const Eds& eds, std::string_view text,
                                         std::uint8_t node_id) {
  canopen::NodeConfig config;
  config.device_type = number_at(eds, {0x1000, 0}, 0);
  config.identity = {number_at(eds, {0x1018, 1}, eds.vendor_number),
                     number_at(eds, {0x1018, 2}, eds.product_number),
                     number_at(eds, {0x1018, 3}, eds.revision), number_at(eds, {0x1018, 4}, 0)};
  config.device_name = text_at(eds, 0x1008);
  config.hardware_version = text_at(eds, 0x1009);
  config.software_version = text_at(eds, 0x100A);
  config.node_id = node_id;
  config.eds = text;
  return config;
}

PlainNode::PlainNode(Eds eds, std::string eds_text, std::uint8_t node_id)
    : eds_(std::move(eds)),
      text_(std::move(eds_text)),
      buffer_(longest_value),
      node_(config_of(eds_, text_, node_id), *this, buffer_) {
  node_.start({}, 0);
}

bool PlainNode::offers(Key key) const {
  const auto at = std::ranges::lower_bound(eds_.objects, Key{key.index, 0}, {}, &EdsObject::key);
  return at != eds_.objects.end() && at->key.index == key.index;
}

Abort PlainNode::find(Key key, Entry& entry) const {
  const auto at = std::ranges::lower_bound(eds_.objects, key, {}, &EdsObject::key);
  if (at == eds_.objects.end() || at->key != key) {
    return offers(key) ? Abort::no_sub : Abort::no_object;
  }
  const auto i = static_cast<std::size_t>(at - eds_.objects.begin());
  // Beyond what a handle counts, the entry is found again by its key.
  entry = {key, at->type, at->access, 0, static_cast<std::uint32_t>(values_[i].size())};
  return Abort::none;
}

Abort PlainNode::read(const Entry& entry, std::uint32_t offset, std::span<std::uint8_t> to) {
  const auto at = std::ranges::lower_bound(eds_.objects, entry.key, {}, &EdsObject::key);
  const auto& value = values_[static_cast<std::size_t>(at - eds_.objects.begin())];
  if (value.size() < offset + to.size()) {
    return Abort::transfer;  // it has been written since
  }
  std::ranges::copy(std::span(value).subspan(offset, to.size()), to.begin());
  return Abort::none;
}

Abort PlainNode::write(const Entry& entry, std::span<const std::uint8_t> from,
                       canopen::Source /*source*/) {
  const auto at = std::ranges::lower_bound(eds_.objects, entry.key, {}, &EdsObject::key);
  if (at->has_limits) {
    const std::uint32_t bits = canopen::take_value(at->type, from);
    const std::int64_t value = canopen::is_signed(at->type)
                                   ? std::int64_t{static_cast<std::int32_t>(bits)}
                                   : std::int64_t{bits};
    if (value < at->min || at->max < value) {
      return value < at->min ? Abort::too_low : Abort::too_high;
    }
  }
  values_[static_cast<std::size_t>(at - eds_.objects.begin())].assign(from.begin(), from.end());
  return Abort::none;
}

void PlainNode::started(std::uint8_t /*node_id*/) {
  values_ = stored_values_;
  if (values_.empty()) {
    for (const EdsObject& object : eds_.objects) {
      values_.push_back(object.standard);
    }
    take_defaults();
  }
}

/// The node's own objects begin as the data sheet says: mappings before the PDOs are valid.
void PlainNode::take_defaults() {
  canopen::Communication& own = node_.objects();
  for (std::size_t i = 0; i < canopen::pdo_count; ++i) {
    own.rpdo[i].cob |= canopen::cob_invalid;
    own.tpdo[i].cob |= canopen::cob_invalid;
    own.rpdo_map[i] = {};
    own.tpdo_map[i] = {};
  }
  own.heartbeat_ms = 0;
  const auto set = [&](const EdsObject& object) {
    Entry entry{};
    if (node_.find(object.key, entry) == Abort::none && (entry.access & canopen::writable) != 0 &&
        entry.key.index != 0x1010 && entry.key.index != 0x1011 && entry.key.index != 0x1003 &&
        object.standard.size() == canopen::size_of(entry.type)) {
      node_.write(entry, object.standard, canopen::Source::device);
    }
  };
  const auto is_cob = [](const EdsObject& object) {
    const unsigned group = object.key.index & 0xFE00U;
    return object.key.sub == 1 && (group == 0x1400 || group == 0x1800);
  };
  const auto is_count = [](const EdsObject& object) {
    const unsigned group = object.key.index & 0xFE00U;
    return object.key.sub == 0 && (group == 0x1600 || group == 0x1A00);
  };
  for (const int pass : {0, 1, 2}) {
    for (const EdsObject& object : eds_.objects) {
      const int cycle = is_cob(object) ? 2 : is_count(object) ? 1 : 0;
      if (is_communication(object.key) && cycle == pass) {
        set(object);
      }
    }
  }
}

void PlainNode::advance(std::uint64_t now_us) {
  node_.advance(now_us);
  using enum canopen::Request;
  switch (node_.request()) {
    case none:
      return;
    case reset_node:
    case reset_communication:
      node_.start(image_, now_us);
      return;
    case restore_all:
    case restore_communication:
    case restore_application:
      stored_values_.clear();
      image_.clear();
      break;
    default:
      stored_values_ = values_;
      image_.resize(canopen::Node::image_size);
      image_.resize(node_.image(image_));
      break;
  }
  node_.finish(node_.request_number(), true);
}

namespace {

volatile std::sig_atomic_t interrupted = 0;  // NOLINT(*-avoid-non-const-global-variables)

std::uint64_t now_us() {
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(
                                        std::chrono::steady_clock::now().time_since_epoch())
                                        .count());
}

template <hal::CanPort P>
void serve(PlainNode& node, P& port) {
  hal::CanFrame frame;
  while (port.receive(frame)) {
    node.receive(frame, now_us());
  }
  node.advance(now_us());
  while (node.take(frame)) {
    port.send(frame);
  }
}

}  // namespace

void run_plain_node(const std::string& eds_file, const std::string& can, std::uint8_t node_id,
                    double duration_s) {
  const std::string text = files::whole_file(eds_file);
  PlainNode node(parse_eds(text, eds_file, node_id), text, node_id);
  hal::LinuxCan port = hal::open_can(can);
  std::signal(SIGINT, [](int) { interrupted = 1; });
  std::signal(SIGTERM, [](int) { interrupted = 1; });
  fmt::print("node {} serves {} on {}\n", node_id, eds_file, can);
  std::fflush(stdout);
  const std::uint64_t start_us = now_us();
  while (interrupted == 0 &&
         (duration_s == 0 || static_cast<double>(now_us() - start_us) < 1e6 * duration_s)) {
    pollfd wait{port.descriptor(), POLLIN, 0};
    poll(&wait, 1, 1);
    serve(node, port);
  }
}

}  // namespace smaservo
