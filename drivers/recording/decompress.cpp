#include "drivers/recording/decompress.hpp"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <memory>
#include <span>

namespace infuse::recording {
namespace {

struct CloseFile {
  void operator()(FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<FILE, CloseFile>;

/// Compressed bytes as they are read from the file.
class Input {
 public:
  explicit Input(File file) : file_(std::move(file)) {}

  /// The bytes not consumed yet, at least one unless the file has ended.
  std::span<const uint8_t> bytes() {
    if (begin_ == end_) {
      begin_ = 0;
      end_ = std::fread(buffer_.data(), 1, buffer_.size(), file_.get());
    }
    return std::span(buffer_).subspan(begin_, end_ - begin_);
  }
  void consume(size_t count) { begin_ += count; }

 private:
  File file_;
  std::array<uint8_t, 1 << 16> buffer_;
  size_t begin_ = 0, end_ = 0;
};

/// The content of a compressed file. A file may hold several members one after the other.
class Decompressor {
 public:
  virtual ~Decompressor() = default;
  /// Reads up to `size` bytes, 0 at the end; −1 if the content is damaged.
  virtual ssize_t read(uint8_t* out, size_t size) = 0;
};

class GzipDecompressor : public Decompressor {
 public:
  explicit GzipDecompressor(File file) : input_(std::move(file)) {
    constexpr int kGzip = 16;
    ready_ = inflateInit2(&stream_, MAX_WBITS + kGzip) == Z_OK;
  }
  ~GzipDecompressor() override { inflateEnd(&stream_); }
  GzipDecompressor(const GzipDecompressor&) = delete;
  GzipDecompressor& operator=(const GzipDecompressor&) = delete;

  ssize_t read(uint8_t* out, size_t size) override {
    if (!ready_) return -1;
    stream_.next_out = out;
    stream_.avail_out = static_cast<uInt>(size);
    while (stream_.avail_out == size) {
      const auto bytes = input_.bytes();
      if (bytes.empty()) return 0;
      stream_.next_in = const_cast<uint8_t*>(bytes.data());  // zlib does not write
      stream_.avail_in = static_cast<uInt>(bytes.size());
      const int status = inflate(&stream_, Z_NO_FLUSH);
      input_.consume(bytes.size() - stream_.avail_in);
      if (status == Z_STREAM_END) {
        inflateReset(&stream_);
      } else if (status != Z_OK) {
        return -1;
      }
    }
    return static_cast<ssize_t>(size - stream_.avail_out);
  }

 private:
  Input input_;
  z_stream stream_{};
  bool ready_ = false;
};

class ZstdDecompressor : public Decompressor {
 public:
  explicit ZstdDecompressor(File file) : input_(std::move(file)) {}

  ssize_t read(uint8_t* out, size_t size) override {
    if (!stream_) return -1;
    ZSTD_outBuffer output{out, size, 0};
    while (output.pos == 0) {
      const auto bytes = input_.bytes();
      ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
      const size_t status = ZSTD_decompressStream(stream_.get(), &output, &in);
      if (ZSTD_isError(status) != 0) return -1;
      input_.consume(in.pos);
      if (bytes.empty() && output.pos == 0) return 0;
    }
    return static_cast<ssize_t>(output.pos);
  }

 private:
  struct FreeStream {
    void operator()(ZSTD_DStream* stream) const { ZSTD_freeDStream(stream); }
  };
  Input input_;
  std::unique_ptr<ZSTD_DStream, FreeStream> stream_{ZSTD_createDStream()};
};

ssize_t read_cookie(void* cookie, char* out, size_t size) {
  const ssize_t count =
      static_cast<Decompressor*>(cookie)->read(reinterpret_cast<uint8_t*>(out), size);
  if (count < 0) errno = EIO;
  return count;
}

int close_cookie(void* cookie) {
  delete static_cast<Decompressor*>(cookie);
  return 0;
}

/// The first bytes of a file.
std::array<uint8_t, 6> first_bytes(FILE* file) {
  std::array<uint8_t, 6> magic{};
  static_cast<void>(std::fread(magic.data(), 1, magic.size(), file) == magic.size());
  std::rewind(file);
  return magic;
}

}  // namespace

const char* unknown_compression(FILE* file) {
  struct Format {
    std::array<uint8_t, 4> begin;
    size_t size;
    const char* command;
  };
  constexpr std::array<Format, 4> kFormats{{{{0xFD, '7', 'z', 'X'}, 4, "unxz"},
                                            {{'B', 'Z', 'h'}, 3, "bunzip2"},
                                            {{0x04, 0x22, 0x4D, 0x18}, 4, "lz4 -d"},
                                            {{'P', 'K', 3, 4}, 4, "unzip"}}};
  const auto begin = first_bytes(file);
  for (const Format& format : kFormats) {
    if (std::equal(format.begin.begin(), format.begin.begin() + format.size, begin.begin())) {
      return format.command;
    }
  }
  return nullptr;
}

FILE* decompress(FILE* file) {
  File owned(file);
  const auto magic = first_bytes(file);
  const bool gzip = magic[0] == 0x1F && magic[1] == 0x8B;
  constexpr std::array<uint8_t, 4> kZstd{0x28, 0xB5, 0x2F, 0xFD};
  const bool zstd = std::equal(kZstd.begin(), kZstd.end(), magic.begin());
  if (!gzip && !zstd) return owned.release();
  std::unique_ptr<Decompressor> content;
  if (gzip) {
    content = std::make_unique<GzipDecompressor>(std::move(owned));
  } else {
    content = std::make_unique<ZstdDecompressor>(std::move(owned));
  }
  FILE* opened = fopencookie(content.get(), "rb", {read_cookie, nullptr, nullptr, close_cookie});
  if (opened != nullptr) static_cast<void>(content.release());  // close_cookie owns it
  return opened;
}

}  // namespace infuse::recording
