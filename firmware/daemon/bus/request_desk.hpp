#pragma once
// Answers the node's requests: stores in parallel to the bus, one request at a time. A result
// belongs to the request with its number; if a reset has replaced that request meanwhile, the
// result is ignored.

#include <chrono>
#include <functional>
#include <future>
#include <string>
#include <utility>
#include <vector>

#include "firmware/canopen/node/node.hpp"
#include "firmware/settings.hpp"

namespace smaservo::daemon {

using Image = std::vector<std::uint8_t>;

/// The data to be stored, copied because the bus goes on meanwhile.
struct StoreJob {
  canopen::Request request = canopen::Request::none;
  std::uint32_t number = 0;
  Settings<double> settings;
  Image image;
};
struct StoreResult {
  canopen::Request request = canopen::Request::none;
  std::uint32_t number = 0;
  std::string problem;  ///< empty if the result is durable
};

/// Stores in a thread of its own, because a disk may be slow.
class StoreThread {
 public:
  /// Stores; returns the error, empty if there is none.
  using Keep = std::function<std::string(const StoreJob&)>;
  explicit StoreThread(Keep keep) : keep_(std::move(keep)) {}

  /// To be called only after the result of the previous job was taken.
  void start(StoreJob job) {
    result_ = std::async(std::launch::async, [keep = keep_, job = std::move(job)] {
      return StoreResult{job.request, job.number, keep(job)};
    });
  }
  bool take(StoreResult& result) {
    if (!result_.valid() ||
        result_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
      return false;
    }
    result = result_.get();
    return true;
  }

 private:
  Keep keep_;
  std::future<StoreResult> result_;
};

/// `Node` is canopen::Servo, `Store` is StoreThread, or classes with the same members.
template <class Node, class Store>
class RequestDesk {
 public:
  RequestDesk(Node& node, Store& store) : node_(node), store_(store) {}

  /// To be called after each round of the bus. `configured()` gives the settings to store;
  /// `done(result)` is called with each result, even if no request waits for it any more. Returns a
  /// reset that the caller has to carry out, otherwise Request::none. A reset waits until a store
  /// in progress has ended, so that the settings in force after it are those in the store.
  template <class Configured, class Done>
  canopen::Request round(Configured configured, Done done) {
    StoreResult result;
    if (busy_ && !store_.take(result)) {
      return canopen::Request::none;
    }
    if (std::exchange(busy_, false)) {
      done(std::as_const(result));
      node_.finish(result.number, result.problem.empty());
    }
    using enum canopen::Request;
    const canopen::Request request = node_.request();
    if (request == none || request == reset_node || request == reset_communication) {
      return request;
    }
    Image image(canopen::Node::image_size);
    image.resize(node_.image(image));
    store_.start({request, node_.request_number(), configured(), std::move(image)});
    busy_ = true;
    return none;
  }

  /// Whether a store is in progress, or its result has not been taken.
  bool is_busy() const { return busy_; }

 private:
  Node& node_;
  Store& store_;
  bool busy_ = false;
};

}  // namespace smaservo::daemon
