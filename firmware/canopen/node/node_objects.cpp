// The node's own objects: reading, writing, and the image in which they are stored.

#include "firmware/canopen/node/index.hpp"
#include "firmware/canopen/node/node.hpp"

namespace smaservo::canopen {
namespace {

constexpr const ObjectRows& own_rows = without_texts<communication_rows>;

bool is_pdo(std::uint16_t index) {
  return 0x1400 <= index && index <= 0x1BFF;
}

/// An unrestricted 11-bit identifier; of the other bits only cob_invalid may be set.
bool is_plain_cob(std::uint32_t value) {
  return (value & ~cob_id_mask & ~cob_invalid) == 0 && !is_restricted(value & cob_id_mask);
}

Request request_of(Key key) {
  using enum Request;
  constexpr std::array<Request, 3> store{store_all, store_communication, store_application};
  constexpr std::array<Request, 3> restore{restore_all, restore_communication, restore_application};
  return (key.index == index::store_parameters ? store : restore)[key.sub - 1U];
}

}  // namespace

std::byte* Node::memory() {
  // The table's offsets are those of this struct, which is plain.
  return reinterpret_cast<std::byte*>(&objects_);  // NOLINT(*-reinterpret-cast)
}

bool Node::is_ours(Key key) const {
  return 0x1000 <= key.index && key.index <= 0x1FFF && application_.offers(key);
}

Abort Node::find(Key key, Entry& entry) const {
  if (!is_ours(key)) {
    return application_.find(key, entry);
  }
  const Abort found = find_object(own_rows, key, entry);
  if (found == Abort::no_object) {
    return application_.find(key, entry);
  }
  if (found == Abort::none && entry.type == Type::text) {
    entry.size = static_cast<std::uint32_t>(text_of(key.index).size());
  }
  if (found == Abort::none && entry.type == Type::domain) {
    entry.size = static_cast<std::uint32_t>(config_.eds.size());
  }
  return found;
}

std::string_view Node::text_of(std::uint16_t index) const {
  return index == index::device_name        ? config_.device_name
         : index == index::hardware_version ? config_.hardware_version
         : index == index::software_version ? config_.software_version
                                            : config_.eds;
}

Abort Node::read(const Entry& entry, std::uint32_t offset, std::span<std::uint8_t> to) {
  if (!is_ours(entry.key) || (!is_highest_sub(entry) && own_rows.size() <= entry.handle)) {
    return application_.read(entry, offset, to);
  }
  if (is_highest_sub(entry)) {
    put_number(to, entry.handle & 0xFFU);
    return Abort::none;
  }
  const Object object = own_rows[entry.handle];
  if (object.key != entry.key) {
    return application_.read(entry, offset, to);
  }
  const bool is_error = entry.key.index == index::error_field && entry.key.sub != 0;
  if ((is_error && objects_.error_count < entry.key.sub) ||
      (entry.type == Type::domain && config_.eds.empty())) {
    return Abort::no_data;
  }
  if (entry.type == Type::text || entry.type == Type::domain) {
    const std::string_view text = text_of(entry.key.index).substr(offset, to.size());
    std::ranges::transform(text, to.begin(), [](char c) { return static_cast<std::uint8_t>(c); });
    return Abort::none;
  }
  put_number(to, object.at == nowhere ? object.standard
                                      : load(object, std::as_bytes(std::span(&objects_, 1))));
  return Abort::none;
}

Abort Node::write(const Entry& entry, std::span<const std::uint8_t> from, Source source) {
  if (!is_ours(entry.key) || own_rows.size() <= entry.handle ||
      own_rows.key(entry.handle) != entry.key) {
    return application_.write(entry, from, source);
  }
  const Object object = own_rows[entry.handle];
  const std::uint32_t value = take_value(object.type, from);
  const std::uint32_t before =
      object.at == nowhere ? 0 : load(object, std::as_bytes(std::span(&objects_, 1)));
  const Abort result =
      application_.may_write(level_of(object.access)) ? write_own(object, value) : Abort::local;
  const bool is_refused = result != Abort::none && result != Abort::pending;
  if (is_refused || (result == Abort::none && (object.access & stored) != 0)) {
    application_.written(entry.key, before, value, source, result);
  }
  return result;
}

Abort Node::write_own(const Object& object, std::uint32_t value) {
  const Key key = object.key;
  if (key.index == index::store_parameters || key.index == index::restore_defaults) {
    return check_signature(key, value);
  }
  Abort refused = check(key, value);
  if (refused == Abort::none) {
    refused = check_range(object.type, value, object.min, object.max);
  }
  if (refused != Abort::none) {
    return refused;
  }
  keep(object, std::span(memory(), sizeof objects_), value);
  written(key);
  if ((object.access & stored) != 0 && key.index != 0x1020) {
    touch();
  }
  return Abort::none;
}

/// The log records at most four bytes of a value.
void Node::refused(const Entry& entry, std::span<const std::uint8_t> from, Abort why) {
  std::array<std::uint8_t, 4> before{};
  const std::uint32_t size = size_of(entry.type);
  if ((entry.access & readable) != 0 && 1 <= size && size <= before.size()) {
    read(entry, 0, std::span(before).first(size));
  }
  const auto value = static_cast<std::uint32_t>(
      take_number(from.first(std::min<std::size_t>(from.size(), before.size()))));
  application_.written(
      entry.key, take_value(entry.type, std::span(before).first(std::min<std::size_t>(size, 4))),
      value, Source::sdo, why);
}

Abort Node::check_signature(Key key, std::uint32_t value) {
  const std::uint32_t signature =
      key.index == index::store_parameters ? store_signature : restore_signature;
  return value == signature ? ask(request_of(key)) : Abort::transfer;
}

Abort Node::check(Key key, std::uint32_t value) const {
  switch (key.index) {
    case index::error_field:
      return value == 0 ? Abort::none : Abort::value;
    case index::sync_cob_id: {
      return is_plain_cob(value) ? Abort::none : Abort::value;
    }
    case index::emergency_cob_id: {
      if (!is_plain_cob(value)) {
        return Abort::value;
      }
      const bool stays_valid = ((objects_.emergency_cob | value) & cob_invalid) == 0;
      return stays_valid && ((value ^ objects_.emergency_cob) & cob_id_mask) != 0 ? Abort::state
                                                                                  : Abort::none;
    }
    case index::heartbeat_consumer:
      return check_consumer(key, value);
    case index::sync_overflow:
      return objects_.sync_period_us != 0 ? Abort::state : value == 1 ? Abort::value : Abort::none;
    default:
      return is_pdo(key.index) ? pdos_.check(key, value) : Abort::none;
  }
}

/// `value` consists of node-id and time. One node must not be watched with two times.
Abort Node::check_consumer(Key key, std::uint32_t value) const {
  const std::uint32_t id = value >> 16U;
  const bool counts = id != 0 && (value & 0xFFFFU) != 0;
  if (id > 127) {
    return Abort::value;
  }
  for (std::size_t i = 0; counts && i < consumer_count; ++i) {
    const std::uint32_t other = objects_.consumers[i];
    if (i + 1 != key.sub && other >> 16U == id && (other & 0xFFFFU) != 0) {
      return Abort::incompatible;
    }
  }
  return Abort::none;
}

void Node::written(Key key) {
  switch (key.index) {
    case index::error_field:
      objects_.errors = {};
      break;
    case index::sync_period:
      sync_alive_ = false;
      break;
    case index::heartbeat_consumer:
      consumers_[key.sub - 1U] = {};
      find_again();
      break;
    case index::heartbeat_producer:
      heartbeat_us_ = now_us_;
      break;
    default:
      if (is_pdo(key.index)) {
        pdos_.changed(key);
        find_again();
        show_errors();
      }
      break;
  }
}

// The image: magic, node-id, bit rate, entries of index, sub-index and value, CRC-16.

namespace {

constexpr std::uint16_t image_magic = 0x4353;
constexpr std::uint8_t image_format = 1;
constexpr std::size_t image_head = 6;
constexpr std::size_t image_entry = 7;
constexpr std::size_t image_crc = 2;

}  // namespace

std::size_t Node::image(std::span<std::uint8_t> to) const {
  put_number(to.first(2), image_magic);
  to[2] = image_format;
  to[3] = lss_node_id_;
  to[4] = lss_bit_rate_;
  to[5] = 0;
  std::size_t at = image_head;
  const auto append = [&](const ObjectRows& table, std::span<const std::byte> memory) {
    for (std::size_t i = 0; i < table.size(); ++i) {
      const Object object = table[i];
      if ((object.access & stored) == 0) {
        continue;
      }
      const std::uint32_t value = load(object, memory);
      if (value == default_of(object, node_id_) || to.size() < at + image_entry + image_crc) {
        continue;
      }
      put_number(to.subspan(at, 2), object.key.index);
      to[at + 2] = object.key.sub;
      put_number(to.subspan(at + 3, 4), value);
      at += image_entry;
    }
  };
  append(own_rows, std::as_bytes(std::span(&objects_, 1)));
  const ObjectTable other = application_.table();
  append(other.rows, other.memory);
  put_number(to.subspan(at, image_crc), crc16(to.first(at)));
  return at + image_crc;
}

/// After a reset of the communication alone the node-id set by LSS stays in force, whether stored
/// or not.
bool Node::load_image(std::span<const std::uint8_t> image, bool keeps_node_id) {
  const std::size_t min = image_head + image_crc;
  const bool good =
      min <= image.size() && (image.size() - min) % image_entry == 0 &&
      take_number(image.first(2)) == image_magic && image[2] == image_format &&
      (image[3] == 0 || may_be_node_id(image[3])) &&
      crc16(image.first(image.size() - image_crc)) == take_number(image.last(image_crc));
  const bool by_lss = good && image[3] != 0;
  lss_bit_rate_ = good ? image[4] : unconfigured;
  lss_node_id_ = by_lss ? image[3] : std::uint8_t{0};
  node_id_ = keeps_node_id ? lss_.pending_node_id() : by_lss ? lss_node_id_ : config_.node_id;

  const std::span own(memory(), sizeof objects_);
  const ObjectTable other = application_.table();
  reset_objects(own_rows, own, node_id_);
  reset_objects(other.rows, other.memory, node_id_);
  objects_.device_type = config_.device_type;
  objects_.identity = config_.identity;
  for (std::size_t at = image_head; good && at + image_entry + image_crc <= image.size();
       at += image_entry) {
    const Key key{static_cast<std::uint16_t>(take_number(image.subspan(at, 2))), image[at + 2]};
    const auto value = static_cast<std::uint32_t>(take_number(image.subspan(at + 3, 4)));
    const bool ours = own_rows.find(key) < own_rows.size();
    const ObjectRows& rows = ours ? own_rows : other.rows;
    const std::size_t row = rows.find(key);
    if (row == rows.size()) {
      continue;
    }
    const Object object = rows[row];
    if ((object.access & stored) != 0 &&
        check_range(object.type, value, object.min, object.max) == Abort::none) {
      keep(object, ours ? own : other.memory, value);
    }
  }
  return good || image.empty();
}

}  // namespace smaservo::canopen
