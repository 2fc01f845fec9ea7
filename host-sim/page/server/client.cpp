#include <algorithm>
#include <array>
#include <fmt/format.h>

#include "host-sim/page/server/body.hpp"
#include "host-sim/page/server/http.hpp"

namespace smaservo::page {
namespace {

/// Greatest number of messages written to one client before the others have their turn.
constexpr int burst = 16;

}  // namespace

// The requests of a client, and the delivery of the answers.

void Server::Body::Client::get_parameters(std::vector<std::string> names,
                                          std::optional<std::string> id) {
  body_.source_.get_parameters(
      std::move(names),
      body_.to_client(id_, [id](Conversation& to, const std::vector<NamedValue>& values) {
        to.parameter_values(values, id, "");
      }));
}

void Server::Body::Client::set_parameters(std::vector<NamedValue> values,
                                          std::optional<std::string> id) {
  body_.source_.set_parameters(
      caller(), std::move(values),
      body_.to_client(
          id_, [id](Conversation& to, const std::vector<NamedValue>& in_force,
                    const std::string& refusal) { to.parameter_values(in_force, id, refusal); }));
}

void Server::Body::Client::call(std::uint32_t service, std::uint32_t call, std::string request) {
  body_.source_.call(caller(), service, std::move(request),
                     body_.to_client(id_, [service, call](Conversation& to, Answer answer) {
                       to.answer(service, call, std::move(answer));
                     }));
}

int Server::Body::Client::hear(std::string_view bytes) {
  if (lws_is_first_fragment(wsi_) != 0) {
    heard_.clear();
  }
  if (heard_.size() + bytes.size() > limits::message_bytes) {
    std::string why = fmt::format("longer than {} bytes", limits::message_bytes);
    // NOLINTNEXTLINE(*-reinterpret-cast): characters as bytes
    auto* const bytes_of_why = reinterpret_cast<unsigned char*>(why.data());
    lws_close_reason(wsi_, LWS_CLOSE_STATUS_MESSAGE_TOO_LARGE, bytes_of_why, why.size());
    return -1;
  }
  heard_ += bytes;
  if (lws_is_final_fragment(wsi_) != 0) {
    if (lws_frame_is_binary(wsi_) != 0) {
      conversation_.hear_bytes(heard_);
    } else {
      conversation_.hear_text(heard_);
    }
    heard_.clear();
  }
  return 0;
}

/// Copies the next piece of the outgoing message to the buffer; returns its length.
std::size_t Server::Body::Client::fill(const Frame& frame) {
  const std::size_t length = std::min(chunk, frame.size() - sent_);
  buffer_.resize(LWS_PRE + length);
  const auto from_head =
      std::string_view(frame.head).substr(std::min(sent_, frame.head.size()), length);
  auto at = std::ranges::copy(from_head, buffer_.begin() + LWS_PRE).out;
  if (from_head.size() < length) {
    const std::size_t start = sent_ + from_head.size() - frame.head.size();
    std::ranges::copy(std::string_view(*frame.body).substr(start, length - from_head.size()), at);
  }
  return length;
}

/// Returns a negative value if the connection has failed.
int Server::Body::Client::write_piece() {
  if (!going_out_) {
    return 0;
  }
  const Frame& frame = *going_out_;
  const std::size_t length = fill(frame);
  const bool last = sent_ + length == frame.size();
  const int flags = lws_write_ws_flags(frame.binary ? LWS_WRITE_BINARY : LWS_WRITE_TEXT,
                                       static_cast<int>(sent_ == 0), static_cast<int>(last));
  sent_ += length;
  if (last) {
    going_out_.reset();
  }
  return lws_write(wsi_, buffer_.data() + LWS_PRE, length, static_cast<lws_write_protocol>(flags));
}

int Server::Body::Client::write() {
  if (doomed_) {
    return -1;
  }
  // Writes several small messages at once, for a client that was not served for a while, but never
  // more than the socket accepts.
  for (int i = 0; i < burst && lws_partial_buffered(wsi_) == 0; ++i) {
    if (!going_out_) {
      going_out_ = queue_.pop();
      sent_ = 0;
    }
    if (!going_out_) {
      break;
    }
    const bool small = going_out_->size() < chunk;
    if (write_piece() < 0) {
      return -1;
    }
    if (!small) {
      break;
    }
  }
  show();
  if (going_out_ || !queue_.empty()) {
    lws_callback_on_writable(wsi_);
  }
  return 0;
}

}  // namespace smaservo::page
