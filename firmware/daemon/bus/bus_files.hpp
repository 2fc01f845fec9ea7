#pragma once
// What the bus stores in its folder: the device's settings, and the image of the node's own
// objects.

#include <string>

#include "firmware/daemon/bus/request_desk.hpp"

namespace smaservo::daemon {

class BusFiles {
 public:
  /// No folder: nothing can be stored.
  explicit BusFiles(std::string folder) : folder_(std::move(folder)) {}

  std::string image_path() const { return folder_ + "/communication"; }
  /// Empty: there is none. A file that has nothing in it, or cannot be read, is a damaged image.
  Image image() const;
  /// Carries a request out; blocks for as long as the disk takes. Returns what went wrong; empty:
  /// it is durable. `image_lost`: the image is damaged, and nobody has stored it anew.
  std::string keep(const StoreJob& job, bool image_lost) const;

 private:
  std::string folder_;
};

}  // namespace smaservo::daemon
