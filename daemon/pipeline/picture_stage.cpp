#include "daemon/pipeline/picture_stage.hpp"

namespace infuse::daemon {

PictureStage::PictureStage(SlotRing<StreamItem>& in, SlotRing<Picture>& out,
                           std::vector<camera::PictureOptions> options, Delivery delivery)
    : in_(in.reader()), out_(out), options_(std::move(options)), delivery_(delivery) {}

void PictureStage::run() {
  bool ended = false;
  while (!ended && in_.wait()) {
    const Pin<StreamItem> item = in_.next();
    if (!item) continue;
    ended = item->kind == StreamItem::Kind::kEnd;
    if (item->kind != StreamItem::Kind::kPicture) continue;
    decode(*item, out_.hand());
    deliver(out_, delivery_);
  }
}

// Of a live camera the estimators need no colour.
Result<void> PictureStage::unpack(const StreamItem& item, CameraFrame& frame) const {
  if (!item.raw) return camera::decode_picture(item.encoded, options_[item.camera], frame);
  camera::RawPicture raw = item.raw->raw;
  raw.bytes = item.encoded;
  frame.exposure = item.raw->exposure;
  frame.gain = item.raw->gain;
  return camera::unpack(raw, true, frame);
}

void PictureStage::decode(const StreamItem& item, Picture& picture) const {
  const HostClock::time_point begin = HostClock::now();
  picture.stamp = item.stamp;
  picture.camera = item.camera;
  picture.number = item.number;
  picture.readable = unpack(item, picture.frame).has_value();
  picture.frame.stamp = item.stamp;
  picture.frame.sequence = item.sequence;
  picture.decoding = HostClock::now() - begin;
}

}  // namespace infuse::daemon
