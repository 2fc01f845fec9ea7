#pragma once
// Live values by SYNC: the bridge is the bus's SYNC producer, and each servo answers with PDOs that
// carry the wanted signals, two in each. At the end the servo's own mapping is restored.

#include <map>
#include <vector>

#include "host-sim/can/remote.hpp"
#include "host-sim/page/servos/history.hpp"

namespace smaservo::page {

class SyncStream {
 public:
  /// `period_s` 0: no SYNC. At most eight signals, which take four PDOs. Throws UserError.
  SyncStream(double period_s, const std::vector<std::string>& signals);

  bool wanted() const { return period_us_ > 0; }
  /// The signals that come by PDO.
  const SignalSet& signals() const { return has_; }

  /// Reads a node's mapping and gives it that of the stream. Throws UserError.
  void map(can::Remote& remote);
  /// Restores the mapping that map() has read. Throws UserError.
  void put_back(can::Remote& remote);
  bool is_mapped(unsigned node) const { return nodes_.contains(node); }
  /// To be called when the node was reset and has lost this mapping.
  void forget(unsigned node) { nodes_.erase(node); }
  std::vector<unsigned> mapped() const;

  /// Sends SYNC if it is due. Returns the time at which the next one is due.
  std::int64_t tick(can::Bus& bus, std::int64_t now_us);
  /// Takes a frame that may be a PDO of the stream. Returns whether it has completed `sample`.
  bool heard(const hal::CanFrame& frame, std::int64_t now_us, unsigned& node, Sample& sample);
  /// Notes a SYNC of another producer; the bridge then sends none.
  void foreign_sync(std::int64_t now_us) {
    foreign_us_ = now_us;
    for (auto& [number, node] : nodes_) {
      ++node.sent;
    }
  }
  bool is_foreign(std::int64_t now_us) const { return now_us - foreign_us_ < 1'000'000; }

  /// Samples that are known to be missing.
  std::uint64_t gaps(unsigned node) const;

 private:
  struct Pdo {
    unsigned number;  ///< 1 to 4
    std::uint32_t cob_id;
    std::vector<std::pair<Key, std::uint32_t>> before;  ///< old values, in the order of restoring
  };
  struct Node {
    std::vector<Pdo> pdos;
    Sample sample;
    std::size_t filled = 0;
    std::int64_t sent = 0, complete = 0;  ///< number of SYNCs; of complete samples
    std::int64_t missing = 0;
    std::int64_t fewest_open = 0;  ///< SYNCs without a sample, the minimum of the last samples
    unsigned judged = 0;
  };
  static void judge_gaps(Node& node);
  static Pdo read_pdo(can::Remote& remote, unsigned number);
  void write_pdo(can::Remote& remote, const Pdo& pdo, std::size_t first) const;

  std::int64_t period_us_;
  std::vector<std::size_t> order_;  ///< order of the signals in the PDOs
  SignalSet has_;
  std::map<unsigned, Node> nodes_;
  std::int64_t due_us_ = 0, foreign_us_ = -1'000'000;
};

}  // namespace smaservo::page
