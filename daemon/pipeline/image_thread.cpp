#include "daemon/pipeline/image_thread.hpp"

namespace infuse::daemon {

ImageThread::ImageThread(SlotRing<StreamItem>& in, SlotRing<CameraImage>& out,
                         const SensorSetup& setup)
    : in_(in.make_reader()), out_(out), delivery_(delivery_of(setup.live)) {
  for (const CameraSetup& camera : setup.cameras) options_.push_back(camera.image);
}

void ImageThread::run() {
  bool ended = false;
  while (!ended && in_.wait()) {
    const Pin<StreamItem> item = in_.next();
    if (!item) continue;
    ended = item->kind == StreamItem::Kind::kEnd;
    if (item->kind != StreamItem::Kind::kImage) continue;
    decode(*item, out_.slot());
    deliver(out_, delivery_);
  }
}

// Live images are unpacked to grey: fusion needs no colour.
Result<void> ImageThread::unpack(const StreamItem& item, CameraFrame& frame) const {
  if (!item.raw) return camera::decode_image(item.encoded, options_[item.camera], frame);
  camera::RawImage raw = item.raw->raw;
  raw.bytes = item.encoded;
  frame.exposure = item.raw->exposure;
  frame.gain = item.raw->gain;
  return camera::unpack(raw, true, frame);
}

void ImageThread::decode(const StreamItem& item, CameraImage& image) const {
  const HostClock::time_point begin = HostClock::now();
  image.stamp = item.stamp;
  image.camera = item.camera;
  image.number = item.number;
  image.readable = unpack(item, image.frame).has_value();
  image.frame.stamp = item.stamp;
  image.frame.sequence = item.sequence;
  image.decode_time = HostClock::now() - begin;
}

}  // namespace infuse::daemon
