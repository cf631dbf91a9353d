#include "drivers/camera/v4l2_source.hpp"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

#include <array>
#include <cmath>

#include "drivers/host/system_error.hpp"

namespace infuse::camera {
namespace {

constexpr uint32_t kBufferCount = 4;
constexpr Duration kControlsPeriod{1'000'000'000};
constexpr int64_t kExposureUnitNs = 100'000;  // ns; V4L2_CID_EXPOSURE_ABSOLUTE counts 100 us

/// The driver's code of a format; the cheapest to read comes first.
struct FourCc {
  uint32_t code;
  RawFormat format;
};
constexpr std::array<FourCc, 12> kFormats = {{
    {V4L2_PIX_FMT_GREY, RawFormat::kGrey},
    {V4L2_PIX_FMT_YUYV, RawFormat::kYuyv},
    {V4L2_PIX_FMT_UYVY, RawFormat::kUyvy},
    {V4L2_PIX_FMT_SRGGB8, RawFormat::kBayerRggb},
    {V4L2_PIX_FMT_SBGGR8, RawFormat::kBayerBggr},
    {V4L2_PIX_FMT_SGBRG8, RawFormat::kBayerGbrg},
    {V4L2_PIX_FMT_SGRBG8, RawFormat::kBayerGrbg},
    {V4L2_PIX_FMT_BGR24, RawFormat::kBgr24},
    {V4L2_PIX_FMT_RGB24, RawFormat::kRgb24},
    {V4L2_PIX_FMT_MJPEG, RawFormat::kMjpeg},
    {V4L2_PIX_FMT_JPEG, RawFormat::kMjpeg},
    {0, RawFormat::kGrey},  // the end
}};

template <class Argument>
bool xioctl(int device, unsigned long request, Argument& argument) {
  int result = 0;
  do {
    result = ioctl(device, request, &argument);
  } while (result < 0 && errno == EINTR);
  return result >= 0;
}

bool has_format(int device, uint32_t code) {
  v4l2_fmtdesc description{};
  description.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  while (xioctl(device, VIDIOC_ENUM_FMT, description)) {
    if (description.pixelformat == code) return true;
    ++description.index;
  }
  return false;
}

const FourCc* choose_format(int device, std::optional<RawFormat> wanted) {
  for (const FourCc& candidate : kFormats) {
    if (candidate.code == 0 || (wanted && candidate.format != *wanted)) continue;
    if (has_format(device, candidate.code)) return &candidate;
  }
  return nullptr;
}

bool set_control(int device, uint32_t id, int64_t value) {
  v4l2_control control{id, static_cast<int32_t>(value)};
  return xioctl(device, VIDIOC_S_CTRL, control);
}

std::optional<int> read_control(int device, uint32_t id) {
  v4l2_control control{id, 0};
  if (!xioctl(device, VIDIOC_G_CTRL, control)) return std::nullopt;
  return control.value;
}

v4l2_buffer make_buffer(uint32_t index) {
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

}  // namespace

std::optional<std::string> V4l2Options::invalid() const {
  if (device.empty() || device.front() != '/') return "'" + device + "' is not a device path";
  if (width < 0 || height < 0 || width > 16384 || height > 16384) {
    return "width and height must be between 0 and 16384";
  }
  if ((width == 0) != (height == 0)) return "give both width and height, or neither";
  if (!(rate_hz >= 0 && rate_hz <= 1000)) return "rate_hz must be between 0 and 1000";
  if (exposure && (exposure->count() <= 0 || exposure->count() > 10'000'000'000)) {
    return "the exposure must be between 0 and 10 s";
  }
  return std::nullopt;
}

V4l2Source::Mapping::Mapping(int device, size_t offset, size_t bytes) {
  void* memory = mmap(nullptr, bytes, PROT_READ, MAP_SHARED, device, static_cast<off_t>(offset));
  if (memory != MAP_FAILED) bytes_ = {static_cast<uint8_t*>(memory), bytes};
}

V4l2Source::Mapping::Mapping(Mapping&& other) noexcept
    : bytes_(std::exchange(other.bytes_, std::span<uint8_t>{})) {}

V4l2Source::Mapping::~Mapping() {
  if (!bytes_.empty()) munmap(bytes_.data(), bytes_.size());
}

Result<V4l2Source> V4l2Source::open(const V4l2Options& options, const host::TimeBase& base) {
  if (auto wrong = options.invalid()) return fail(*wrong, options.device);
  V4l2Source source(options, base);
  source.device_ =
      host::FileDescriptor(::open(options.device.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  if (!source.device_) {
    return host::fail_errno("cannot be opened", options.device,
                            errno == EACCES ? "add the user to the group video" : "");
  }
  for (const auto step : {&V4l2Source::check_capabilities, &V4l2Source::negotiate,
                          &V4l2Source::set_rate, &V4l2Source::set_controls, &V4l2Source::start}) {
    const auto done = (source.*step)();
    if (done) continue;
    // Cameras that share a USB bus do not fit it uncompressed.
    if (!source.no_bandwidth_ || options.format ||
        !has_format(source.device_.get(), V4L2_PIX_FMT_MJPEG)) {
      return tl::unexpected(done.error());
    }
    V4l2Options compressed = options;
    compressed.format = RawFormat::kMjpeg;
    source = V4l2Source(options, base);  // closes the device
    return open(compressed, base);
  }
  return source;
}

V4l2Source::~V4l2Source() {
  if (!device_) return;
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  xioctl(device_.get(), VIDIOC_STREAMOFF, type);
}

Result<void> V4l2Source::check_capabilities() {
  v4l2_capability about{};
  if (!xioctl(device_.get(), VIDIOC_QUERYCAP, about)) {
    return host::fail_errno("not a Video4Linux2 device", options_.device);
  }
  const uint32_t able =
      about.capabilities & V4L2_CAP_DEVICE_CAPS ? about.device_caps : about.capabilities;
  if (!(able & V4L2_CAP_VIDEO_CAPTURE) || !(able & V4L2_CAP_STREAMING)) {
    return fail("not a streaming camera", options_.device,
                "a camera may have several devices; try another");
  }
  return {};
}

Result<void> V4l2Source::negotiate() {
  const FourCc* chosen = choose_format(device_.get(), options_.format);
  if (chosen == nullptr) {
    return fail(options_.format ? std::string("does not support ") + name_of(*options_.format)
                                : "has no supported pixel format",
                options_.device, "v4l2-ctl --list-formats-ext lists its formats");
  }
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (!xioctl(device_.get(), VIDIOC_G_FMT, format)) {
    return host::fail_errno("cannot read the current format", options_.device);
  }
  v4l2_pix_format& pixels = format.fmt.pix;
  if (options_.width != 0) {
    pixels.width = static_cast<uint32_t>(options_.width);
    pixels.height = static_cast<uint32_t>(options_.height);
  }
  pixels.pixelformat = chosen->code;
  pixels.field = V4L2_FIELD_NONE;
  pixels.bytesperline = 0;
  if (!xioctl(device_.get(), VIDIOC_S_FMT, format)) {
    return host::fail_errno("cannot be set up", options_.device,
                            errno == EBUSY ? "in use by another program" : "");
  }
  image_layout_ = {chosen->format,
                   static_cast<int>(pixels.width),
                   static_cast<int>(pixels.height),
                   pixels.bytesperline,
                   {}};
  const bool size_granted = options_.width == 0 || (image_layout_.width == options_.width &&
                                                    image_layout_.height == options_.height);
  if (!size_granted || pixels.pixelformat != chosen->code) {
    return fail("does not support " + std::to_string(options_.width) + "x" +
                    std::to_string(options_.height) + " in " + name_of(chosen->format) + ", but " +
                    std::to_string(pixels.width) + "x" + std::to_string(pixels.height),
                options_.device, "v4l2-ctl --list-formats-ext lists its formats");
  }
  return {};
}

Result<void> V4l2Source::set_rate() {
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  v4l2_fract& period = parameters.parm.capture.timeperframe;
  if (options_.rate_hz > 0) {
    period = {1000, static_cast<uint32_t>(std::lround(options_.rate_hz * 1000))};
    if (!xioctl(device_.get(), VIDIOC_S_PARM, parameters)) {
      return host::fail_errno("cannot set the rate", options_.device, "remove rate_hz");
    }
  }
  if (xioctl(device_.get(), VIDIOC_G_PARM, parameters) && period.numerator != 0) {
    rate_hz_ = static_cast<double>(period.denominator) / static_cast<double>(period.numerator);
  }
  return {};
}

Result<void> V4l2Source::set_controls() {
  const int device = device_.get();
  if (options_.exposure) {
    set_control(device, V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL);
    if (!set_control(device, V4L2_CID_EXPOSURE_ABSOLUTE,
                     options_.exposure->count() / kExposureUnitNs)) {
      return host::fail_errno("cannot set the exposure", options_.device, "remove exposure_ms");
    }
  }
  if (options_.gain) {
    set_control(device, V4L2_CID_AUTOGAIN, 0);
    if (!set_control(device, V4L2_CID_GAIN, *options_.gain)) {
      return host::fail_errno("cannot set the gain", options_.device, "remove gain");
    }
  }
  return {};
}

Result<void> V4l2Source::start() {
  v4l2_requestbuffers request{};
  request.count = kBufferCount;
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  if (!xioctl(device_.get(), VIDIOC_REQBUFS, request)) {
    return host::fail_errno("cannot allocate buffers", options_.device,
                            errno == EBUSY ? "in use by another program" : "");
  }
  for (uint32_t i = 0; i < request.count; ++i) {
    v4l2_buffer buffer = make_buffer(i);
    if (!xioctl(device_.get(), VIDIOC_QUERYBUF, buffer)) {
      return host::fail_errno("cannot query buffers", options_.device);
    }
    buffers_.emplace_back(device_.get(), buffer.m.offset, buffer.length);
    if (buffers_.back().bytes().empty() || !xioctl(device_.get(), VIDIOC_QBUF, buffer)) {
      return host::fail_errno("cannot map buffers", options_.device);
    }
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (!xioctl(device_.get(), VIDIOC_STREAMON, type)) {
    no_bandwidth_ = errno == ENOSPC;
    return host::fail_errno("cannot start streaming", options_.device,
                            no_bandwidth_ ? "other cameras use its USB bus: set a smaller "
                                            "width or rate_hz, or use another USB controller"
                                          : "");
  }
  return {};
}

Result<V4l2Source::Dequeued> V4l2Source::dequeue(uint32_t& index, StreamedImage& image) {
  v4l2_buffer buffer = make_buffer(0);
  if (!xioctl(device_.get(), VIDIOC_DQBUF, buffer)) {
    if (errno == EAGAIN) return Dequeued::kNone;
    return host::fail_errno("cannot be read", options_.device);
  }
  if (buffer.index >= buffers_.size())
    return fail("the driver returned an unknown buffer", options_.device);
  index = buffer.index;
  if (counters_.images + counters_.damaged > 0 && buffer.sequence > next_sequence_) {
    counters_.lost += buffer.sequence - next_sequence_;
  }
  next_sequence_ = buffer.sequence + 1;
  if (buffer.flags & V4L2_BUF_FLAG_ERROR) {
    ++counters_.damaged;
    return Dequeued::kDamaged;
  }
  ++counters_.images;
  read_controls(base_.now());
  const int64_t monotonic_ns =
      int64_t{buffer.timestamp.tv_sec} * 1'000'000'000 + int64_t{buffer.timestamp.tv_usec} * 1000;
  image = {exposure_stamp(monotonic_ns, buffer.flags), exposure_, gain_, buffer.sequence,
           image_layout_};
  const auto mapped = buffers_[index].bytes();
  image.raw.bytes = mapped.first(std::min<size_t>(buffer.bytesused, mapped.size()));
  return Dequeued::kImage;
}

Result<void> V4l2Source::requeue(uint32_t index) {
  v4l2_buffer buffer = make_buffer(index);
  if (!xioctl(device_.get(), VIDIOC_QBUF, buffer)) {
    return host::fail_errno("cannot requeue a buffer", options_.device);
  }
  return {};
}

// Reading them costs a transfer on the camera's bus, and both change slowly.
void V4l2Source::read_controls(Stamp now) {
  if (now - last_controls_read_ < kControlsPeriod) return;
  last_controls_read_ = now;
  if (const auto units = read_control(device_.get(), V4L2_CID_EXPOSURE_ABSOLUTE)) {
    exposure_ = Duration(*units * kExposureUnitNs);
  }
  if (const auto gain = read_control(device_.get(), V4L2_CID_GAIN)) gain_ = *gain;
}

Stamp V4l2Source::exposure_stamp(int64_t monotonic_ns, uint32_t flags) const {
  const bool monotonic =
      (flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  const Stamp stamp = monotonic ? base_.at_monotonic(monotonic_ns) : base_.now();
  const bool at_start = (flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  return (at_start ? stamp + exposure_ / 2 : stamp - exposure_ / 2) - options_.stamp_delay;
}

std::string V4l2Source::description() const {
  std::array<char, 64> text{};
  snprintf(text.data(), text.size(), "%s %dx%d, %.2f Hz", name_of(image_layout_.format),
           image_layout_.width, image_layout_.height, rate_hz_);
  return text.data();
}

}  // namespace infuse::camera
