// The start-up dialogue of a CiA 402 drive, step by step; see start_up.hpp. Sources: README.md.
#include "drivers/cia402/start_up.hpp"

#include <cmath>

#include "drivers/cia402/errors.hpp"

namespace geodesic::drivers::cia402 {

namespace {

constexpr const char* kNoAnswer =
    "the drive is on the bus but does not answer for this object: check its firmware and the bus";

bool lacks(std::uint32_t code) noexcept {
  switch (static_cast<Abort>(code)) {
    case Abort::kNoObject:
    case Abort::kNoSub:
    case Abort::kUnsupportedAccess:
    case Abort::kReadOnly:
      return true;
    default:
      return false;
  }
}

bool agrees(const Transfer& transfer, std::uint32_t found) noexcept {
  switch (transfer.compare) {
    case Transfer::Compare::kAny:
      return true;
    case Transfer::Compare::kEqual:
      return (found & transfer.mask) == (transfer.value & transfer.mask);
    case Transfer::Compare::kAllBits:
      return (found & transfer.value) == transfer.value;
    case Transfer::Compare::kAtLeast:
      return found >= transfer.value;
  }
  return false;
}

/// Signed objects are small numbers here but for what a drive makes of them.
std::uint32_t cut(std::uint32_t value, std::uint8_t bytes) noexcept {
  return bytes >= 4 ? value : value & ((1U << (8U * bytes)) - 1U);
}

}  // namespace

StartUp::StartUp(const DriveOptions& options, const Units& units) noexcept
    : node_(static_cast<std::uint8_t>(options.id)),
      reset_(choice<Reset>(options, Setting::kReset)),
      plan_(make_plan(options, units)) {}

void StartUp::restart() noexcept {
  enter(Step::kReset);
  at_ = 0;
  revision_ = 0;
  heard_ = false;
  complaint_ = {};
}

void StartUp::enter(Step step) noexcept {
  step_ = step;
  awaiting_ = false;
  tries_ = 0;
  looks_ = 0;
}

void StartUp::next(std::size_t count) noexcept {
  at_ += count;
  enter(at_ < plan_.count ? Step::kTransfer : Step::kStart);
}

void StartUp::refuse(const DriveComplaint& complaint) noexcept {
  complaint_ = complaint;
  enter(Step::kRefused);
}

Frame StartUp::request() const noexcept {
  if (step_ == Step::kTransfer) {
    const Transfer& transfer = plan_.transfers[at_];
    return transfer.kind == Transfer::Kind::kWrite
               ? encode_write(node_, transfer.object, transfer.value)
               : encode_read(node_, transfer.object);
  }
  if (step_ == Step::kStart) {
    return encode_nmt({NmtCommand::kStart, node_});
  }
  switch (reset_) {
    case Reset::kCommunication:
      return encode_nmt({NmtCommand::kResetCommunication, node_});
    case Reset::kNode:
      return encode_nmt({NmtCommand::kResetNode, node_});
    case Reset::kNone:
      break;
  }
  return encode_nmt({NmtCommand::kPreOperational, node_});
}

bool StartUp::transmit(std::int64_t now_ns, Frame& out) noexcept {
  if (done() || refused() || (awaiting_ && now_ns - asked_ns_ < patience_ns_)) {
    return false;
  }
  if (step_ == Step::kTransfer && awaiting_ && heard_ && ++tries_ >= kMaxTries) {
    refuse({plan_.transfers[at_].quantity, std::nan(""),
            static_cast<double>(plan_.transfers[at_].value), kNoAnswer});
    return false;
  }
  out = request();
  asked_ns_ = now_ns;
  switch (step_) {
    case Step::kReset:
      patience_ns_ = kBootTimeoutNs;
      awaiting_ = true;
      if (reset_ == Reset::kNone) {
        enter(Step::kTransfer);  // it sends no boot-up: the first transfer finds it
      }
      break;
    case Step::kStart:
      patience_ns_ = kStartTimeoutNs;
      awaiting_ = true;
      break;
    case Step::kTransfer:
    case Step::kDone:
    case Step::kRefused:
      patience_ns_ = kReplyTimeoutNs;
      awaiting_ = true;
      break;
  }
  return true;
}

void StartUp::receive_sdo(const Sdo& reply) noexcept {
  heard_ = true;
  if (step_ != Step::kTransfer || !awaiting_) {
    return;
  }
  const Transfer& transfer = plan_.transfers[at_];
  if (reply.index != transfer.object.index || reply.sub != transfer.object.sub) {
    return;
  }
  switch (reply.kind) {
    case Sdo::Kind::kAbort:
      take_abort(reply.value);
      break;
    case Sdo::Kind::kReadReply:
      if (transfer.kind != Transfer::Kind::kWrite) {
        take_value(cut(reply.value, transfer.object.bytes));
      }
      break;
    case Sdo::Kind::kWriteReply:
      if (transfer.kind == Transfer::Kind::kWrite) {
        next(1);
      }
      break;
    case Sdo::Kind::kRead:
    case Sdo::Kind::kWrite:
      break;
  }
}

void StartUp::take_value(std::uint32_t raw) noexcept {
  const Transfer& transfer = plan_.transfers[at_];
  if (transfer.object == object::kRevision) {
    revision_ = raw;
  }
  if (agrees(transfer, raw)) {
    next(1);
  } else if (transfer.kind == Transfer::Kind::kAwait && ++looks_ < kMaxLooks) {
    patience_ns_ = kPollNs;  // looks again after that
    tries_ = -1;
  } else {
    refuse({transfer.quantity, static_cast<double>(raw & transfer.mask),
            static_cast<double>(transfer.value & transfer.mask), transfer.fix});
  }
}

void StartUp::take_abort(std::uint32_t code) noexcept {
  const Transfer& transfer = plan_.transfers[at_];
  if (transfer.may_lack && lacks(code)) {
    next(1U + transfer.skipped_if_lacking);
  } else {
    refuse({transfer.quantity, std::nan(""), static_cast<double>(transfer.value),
            abort_meaning(code)});
  }
}

void StartUp::receive_state(NmtState state) noexcept {
  heard_ = true;
  if (done() || refused()) {
    return;
  }
  if (state == NmtState::kBootUp) {
    at_ = 0;  // it has just booted: whatever was told to it before is gone
    enter(Step::kTransfer);
  } else if (step_ == Step::kStart && state == NmtState::kOperational) {
    enter(Step::kDone);
  }
}

void StartUp::receive_process_data() noexcept {
  heard_ = true;
  if (step_ == Step::kStart && awaiting_) {
    enter(Step::kDone);
  }
}

}  // namespace geodesic::drivers::cia402
