#include "hal/linux/system/file_store.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <unistd.h>

#include "hal/linux/system/descriptor.hpp"

namespace smaservo::hal {
namespace {

bool write_all(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(file, bytes.data(), bytes.size());
    if (n <= 0) {
      if (n < 0 && errno == EINTR) {
        continue;
      }
      return false;
    }
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return true;
}

}  // namespace

std::string FileStore::path(unsigned slot) const {
  return folder_ + "/settings." + std::to_string(slot);
}

bool FileStore::read(unsigned slot, std::size_t offset, std::span<std::byte> to) {
  const Slot& pending = slots_.at(slot);
  if (offset + to.size() > slot_size) {
    return false;
  }
  if (pending.dirty) {
    std::ranges::fill(to, std::byte{0xFF});
    for (std::size_t i = 0; i < to.size() && offset + i < pending.bytes.size(); ++i) {
      to[i] = pending.bytes[offset + i];
    }
    return true;
  }
  const Descriptor file(open(path(slot).c_str(), O_RDONLY | O_CLOEXEC));
  if (file.number() < 0) {
    std::ranges::fill(to, std::byte{0xFF});
    return errno == ENOENT;
  }
  return pread(file.number(), to.data(), to.size(), static_cast<off_t>(offset)) ==
         static_cast<ssize_t>(to.size());
}

bool FileStore::erase(unsigned slot) {
  slots_.at(slot) = {{}, true};
  return true;
}

bool FileStore::write(unsigned slot, std::size_t offset, std::span<const std::byte> from) {
  if (offset + from.size() > slot_size) {
    return false;
  }
  Slot& s = slots_.at(slot);
  s.bytes.resize(std::max(s.bytes.size(), offset + from.size()), std::byte{0xFF});
  std::ranges::copy(from, s.bytes.begin() + static_cast<std::ptrdiff_t>(offset));
  s.dirty = true;
  return true;
}

bool FileStore::sync() {
  for (unsigned slot = 0; slot < slots_.size(); ++slot) {
    Slot& s = slots_.at(slot);
    if (s.dirty && !replace(slot)) {
      return false;
    }
    s = {};
  }
  return true;
}

bool FileStore::replace(unsigned slot) {
  const std::string beside = path(slot) + ".part";
  // An existing file of this name may be another user's, a link or a pipe. Only one process at a
  // time stores here, so nobody uses it any more.
  std::remove(beside.c_str());
  {
    const Descriptor file(open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0640));
    if (file.number() < 0 || !write_all(file.number(), slots_.at(slot).bytes) ||
        fsync(file.number()) != 0) {
      std::remove(beside.c_str());
      return false;
    }
  }
  if (std::rename(beside.c_str(), path(slot).c_str()) != 0) {
    std::remove(beside.c_str());
    return false;
  }
  const Descriptor folder(open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return folder.number() >= 0 && fsync(folder.number()) == 0;
}

}  // namespace smaservo::hal
