#include <pybind11/stl.h>

#include <variant>

#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/makers/makers.hpp"
#include "drivers/recording/pcap_reader.hpp"
#include "packaging/python/arrays.hpp"
#include "packaging/python/bindings.hpp"
#include "packaging/python/sweep_memory.hpp"

namespace infuse::python {
namespace {

std::unique_ptr<lidar::LidarDecoder> make_decoder(const std::string& model,
                                                  const std::optional<std::string>& calibration) {
  lidar::DecoderOptions options;
  options.model = value_or_raise(makers::require_model(model, "model"));
  if (calibration) {
    options.calibration =
        value_or_raise(options.model->maker->load_calibration(*options.model, *calibration));
  }
  return value_or_raise(lidar::make_decoder(options));
}

/// Sweeps of the datagrams of one sensor.
class Decoder {
 public:
  Decoder(const std::string& model, const std::optional<std::string>& calibration)
      : decoder_(make_decoder(model, calibration)) {}

  std::vector<Sweep> push(const py::bytes& payload, int64_t stamp_ns, uint16_t port) {
    const std::string_view bytes = payload;
    const Work work(busy_);
    decoder_->push({.stamp = Stamp::from_ns(stamp_ns),
                    .destination_port = port,
                    .payload = {reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}});
    return pull();
  }

  std::vector<Sweep> finish() {
    const Work work(busy_);
    decoder_->finish();
    return pull();
  }

 private:
  std::vector<Sweep> pull() {
    std::vector<Sweep> sweeps;
    while (decoder_->pull(sweep_)) sweeps.push_back(std::exchange(sweep_, recycled_sweep()));
    return sweeps;
  }

  std::unique_ptr<lidar::LidarDecoder> decoder_;
  Sweep sweep_;
  bool busy_ = false;
};

/// Sweeps of a capture, one after the other.
class DecodedCapture {
 public:
  DecodedCapture(const std::variant<py::bytes, std::string>& source, const std::string& model,
                 const std::optional<std::string>& calibration)
      : decoder_(make_decoder(model, calibration)),
        bytes_(std::holds_alternative<py::bytes>(source) ? std::get<py::bytes>(source)
                                                         : py::bytes()),
        reader_(open(source)) {}

  /// The next sweep; StopIteration at the end.
  Sweep next() {
    bool found = false;
    {
      const Work work(busy_);
      found = read();
    }
    if (!found) throw py::stop_iteration();
    return std::exchange(sweep_, recycled_sweep());
  }

 private:
  recording::PcapReader open(const std::variant<py::bytes, std::string>& source) {
    if (const auto* path = std::get_if<std::string>(&source)) {
      return value_or_raise(recording::PcapReader::open(*path));
    }
    const std::string_view bytes = bytes_;
    return value_or_raise(recording::PcapReader::from_bytes(
        {reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, "bytes"));
  }

  bool read() {
    while (true) {
      if (decoder_->pull(sweep_)) return true;
      if (ended_) return false;
      Datagram datagram;
      if (reader_.next(datagram)) {
        decoder_->push(datagram);
      } else {
        decoder_->finish();
        ended_ = true;
      }
    }
  }

  std::unique_ptr<lidar::LidarDecoder> decoder_;
  py::bytes bytes_;  // that the reader reads
  recording::PcapReader reader_;
  Sweep sweep_;
  bool ended_ = false;
  bool busy_ = false;
};

/// Path-like arguments as text, bytes as they are.
std::variant<py::bytes, std::string> bytes_or_path(const py::object& source) {
  if (py::isinstance<py::bytes>(source)) return source.cast<py::bytes>();
  return py::module_::import("os").attr("fspath")(source).cast<std::string>();
}

}  // namespace

void bind_lidar(py::module_& module) {
  module.def(
      "models",
      [] {
        std::vector<std::string> names;
        for (const lidar::LidarMaker* maker : makers::all()) {
          for (const lidar::LidarModel& model : maker->models()) names.emplace_back(model.name);
        }
        return names;
      },
      "Names of the lidar models that can be decoded.");
  py::class_<DecodedCapture>(module, "DecodedCapture", "Iterator over the sweeps of a capture.")
      .def("__iter__", [](py::object self) { return self; })
      .def("__next__", &DecodedCapture::next);
  module.def(
      "decode",
      [](const py::object& source, const std::string& model,
         const std::optional<std::string>& calibration) {
        return std::make_unique<DecodedCapture>(bytes_or_path(source), model, calibration);
      },
      py::arg("source"), py::arg("model"), py::kw_only(), py::arg("calibration") = py::none(),
      "Decodes the lidar of a capture: an iterator of Sweep.\n\n"
      "source: bytes of a pcap or pcapng file, or its path. model: as in models(). calibration: "
      "path of the unit's file. Error: it cannot be read, the model is not known or needs a "
      "calibration.");
  py::class_<Decoder>(module, "Decoder",
                      "Decodes UDP payloads of one sensor as they arrive. One thread at a time.")
      .def(py::init<const std::string&, const std::optional<std::string>&>(), py::arg("model"),
           py::kw_only(), py::arg("calibration") = py::none())
      .def("push", &Decoder::push, py::arg("payload"), py::arg("stamp_ns"), py::arg("port") = 2368,
           "Adds a payload with its receive time (ns); returns the sweeps that it completes.")
      .def("finish", &Decoder::finish, "Ends the stream; returns what is left.");
}

}  // namespace infuse::python
