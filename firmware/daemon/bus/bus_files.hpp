#pragma once
// The files that the bus stores in its folder: the device's settings, and the image of the node's
// own objects.

#include <string>

#include "firmware/daemon/bus/request_desk.hpp"

namespace smaservo::daemon {

class BusFiles {
 public:
  /// `folder` empty: nothing can be stored.
  explicit BusFiles(std::string folder) : folder_(std::move(folder)) {}

  std::string image_path() const { return folder_ + "/communication"; }
  /// The stored image; empty if there is none. An empty file, or one that cannot be read, is a
  /// damaged image.
  Image image() const;
  /// Carries a request out; blocks until the disk is done. Returns the error; empty if the result
  /// is durable. `image_lost`: the image is damaged and has not been stored anew.
  std::string keep(const StoreJob& job, bool image_lost) const;

 private:
  std::string folder_;
};

}  // namespace smaservo::daemon
