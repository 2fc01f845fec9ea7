#pragma once
// A node that serves any data sheet with plain storage: what is written is read again. For tests of
// masters, and of this stack by foreign test suites.

#include <memory>

#include "firmware/canopen/node/node.hpp"
#include "tests/can/eds_node/eds_file.hpp"

namespace smaservo {

class PlainNode final : private canopen::Application {
 public:
  PlainNode(Eds eds, std::string eds_text, std::uint8_t node_id);
  PlainNode(const PlainNode&) = delete;
  PlainNode& operator=(const PlainNode&) = delete;
  ~PlainNode() = default;

  void receive(const hal::CanFrame& frame, std::uint64_t now_us) { node_.receive(frame, now_us); }
  /// Answers requests of the node by itself: what it stores lasts as long as this object.
  void advance(std::uint64_t now_us);
  bool take(hal::CanFrame& frame) { return node_.take(frame); }
  canopen::Node& node() { return node_; }

 private:
  canopen::Abort find(Key key, canopen::Entry& entry) const override;
  canopen::Abort read(const canopen::Entry& entry, std::uint32_t offset,
                      std::span<std::uint8_t> to) override;
  canopen::Abort write(const canopen::Entry& entry, std::span<const std::uint8_t> from,
                       canopen::Source source) override;
  bool offers(Key key) const override;
  void started(std::uint8_t node_id) override;

  static canopen::NodeConfig config_of(const Eds& eds, std::string_view text, std::uint8_t node_id);
  void take_defaults();

  Eds eds_;
  std::string text_;
  std::vector<std::vector<std::uint8_t>> values_, stored_values_;
  std::vector<std::uint8_t> buffer_, image_;
  canopen::Node node_;
};

/// Runs one on a CAN port until the program is interrupted, or for so long; 0: for ever. Throws
/// CanError, UserError.
void run_plain_node(const std::string& eds_file, const std::string& can, std::uint8_t node_id,
                    double duration_s);

}  // namespace smaservo
