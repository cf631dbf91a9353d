#include "daemon/pipeline/picture_stage.hpp"

namespace infuse::daemon {

PictureStage::PictureStage(SlotRing<StreamItem>& in, SlotRing<Picture>& out,
                           std::vector<camera::PictureOptions> options)
    : in_(in.reader()), out_(out), options_(std::move(options)) {}

void PictureStage::run() {
  bool ended = false;
  while (!ended && in_.wait()) {
    const Pin<StreamItem> item = in_.next();
    if (!item) continue;
    ended = item->kind == StreamItem::Kind::kEnd;
    if (item->kind != StreamItem::Kind::kPicture) continue;
    decode(*item, out_.hand());
    out_.wait_for_room();
    out_.publish();
  }
}

void PictureStage::decode(const StreamItem& item, Picture& picture) const {
  const HostClock::time_point begin = HostClock::now();
  picture.stamp = item.stamp;
  picture.camera = item.camera;
  picture.number = item.number;
  picture.readable =
      camera::decode_picture(item.encoded, options_[item.camera], picture.frame).has_value();
  picture.frame.stamp = item.stamp;
  picture.frame.sequence = item.sequence;
  picture.decoding = HostClock::now() - begin;
}

}  // namespace infuse::daemon
