// Decodes a capture of one lidar: decode CAPTURE MODEL
#include <cstdio>
#include <infuse/lidar.hpp>
#include <infuse/recording.hpp>

int main(int count, char** arguments) {
  if (count != 3) return 2;
  auto capture = infuse::recording::PcapReader::open(arguments[1]);
  auto model = infuse::makers::require_model(arguments[2], "MODEL");
  auto decoder =
      model ? infuse::lidar::make_decoder({.model = *model}) : tl::unexpected(model.error());
  if (!capture || !decoder) {
    std::puts((capture ? decoder.error() : capture.error()).message().c_str());
    return 1;
  }
  infuse::Datagram datagram;
  infuse::Sweep sweep;
  const auto pull = [&] {
    for (; (*decoder)->pull(sweep); sweep.clear()) {
      std::printf("%lld %zu\n", static_cast<long long>(sweep.stamp.ns()), sweep.size());
    }
  };
  while (capture->next(datagram)) {
    (*decoder)->push(datagram);
    pull();
  }
  (*decoder)->finish();
  pull();
}
